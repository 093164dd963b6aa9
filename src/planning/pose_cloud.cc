#include "armtrue/planning/pose_cloud.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/campaign/sights.h"
#include "armtrue/campaign/usual_noise.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/fold.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "planning/planned_readings.h"

namespace armtrue {
namespace {

constexpr double kOnTheFloor = 1e-9;             // m; a frame in the plane of the base is above it
constexpr int kDrawsPerConfiguration = 64;

// Height in R_0 of the lowest origin of a link of the arm, point of the tool or target [m].
double lowest_height(const Robot& robot, const JointVector& q) {
  const KinematicChain& chain = robot.chain;
  const LinkFrames frames = ChainEvaluator(chain).link_frames(q);
  const int ground = robot.ground_link.value_or(-1);  // what a positioner moves stands before it
  const Pose floor_from_foot = ground < 0 ? Pose{} : inverse(frames[ground]);
  const auto height = [&](const Eigen::Vector3d& point) { return (floor_from_foot * point).z(); };
  const Pose tool = frames.back() * chain.tool;
  double lowest = height(tool.translation);
  for (const Target& target : chain.targets)
    lowest = std::min(lowest, height(tool * target.position));
  for (size_t link = ground + 1; link < frames.size(); ++link)
    if (!is_prismatic(chain.links[link]))
      lowest = std::min(lowest, height(frames[link].translation));
  return lowest;
}

// The floor that half of the configurations keep above, in whole mm.
[[noreturn]] void fail_below_floor(const Robot& robot, const std::vector<JointVector>& drawn) {
  std::vector<double> heights;
  for (const JointVector& q : drawn) heights.push_back(lowest_height(robot, q));
  throw std::invalid_argument(fmt::format(
      "hardly any configuration keeps links and tool above the floor; move the box up or lower the "
      "floor, whose height in R_0 'floor_mm' of the robot file or --floor-mm states: a gantry, or "
      "an arm on a wall, works below its foot; with --floor-mm {:.0f} half of them are above it",
      std::floor(median(heights) / kMillimetre)));
}

}  // namespace

bool is_above_floor(const PoseCloud& cloud, const JointVector& q) {
  return lowest_height(cloud.robot, q) >=
         cloud.options.floor.value_or(cloud.robot.floor) - kOnTheFloor;
}

namespace {

// The planned poses are read as the given ones were.
void choose_kinds(PoseCloud& cloud) {
  KinematicChain& chain = cloud.robot.chain;
  ReadingKinds& kinds = cloud.options;
  if (cloud.given.rows() > 0) {
    kinds = kinds_of(cloud.given);
    if (cloud.given.target_names.empty()) chain.targets.clear();
  }
  kinds = with_usual_kind(kinds, chain);
  if (!kinds.points && !kinds.distances && !kinds.touches) chain.targets.clear();
  if (!kinds.distances) chain.anchors.clear();
}

// The places of contacts, cameras and boards, from the robot file or the given readings.
void find_places(PoseCloud& cloud) {
  if (cloud.options.box)
    throw std::invalid_argument(
        "a box limits poses in free space; where a contact is touched, a camera sees a board, or a "
        "beam or a scanner reads a plane, their places say where");
  cloud.robot = with_contacts_fitted(std::move(cloud.robot), cloud.given, FitContacts::unplaced);
  if (cloud.options.beams) state_ranges(cloud.given, cloud.robot.chain);
  if (cloud.options.touches)
    cloud.touches = cloud.given.rows() > 0 ? touches_of(cloud.given, cloud.robot.chain)
                                           : touch_sights_of(cloud.robot.chain);
}

}  // namespace

PoseCloud pose_cloud(const Robot& robot, const CloudOptions& options, const Campaign& given) {
  PoseCloud cloud;
  cloud.robot = robot;
  cloud.options = options;
  cloud.given = given;
  const std::vector<std::vector<int>> sessions = rows_by_session(given);
  if (given.rows() > 0) cloud.robot = robot_at_row(robot, given, sessions.back().front());
  cloud.robot.sessions = robot.sessions;
  cloud.robot.effects.clear();
  cloud.noise_length = stated_or_usual(0, robot.noise.position, kUsualPositionNoise);
  cloud.noise_pixel = stated_or_usual(0, robot.noise.pixel, kUsualPixelNoise);
  cloud.noise = {cloud.noise_length,
                 stated_or_usual(0, robot.noise.orientation, kUsualOrientationNoise)};
  cloud.stated_noise = stated_by_kind(given);
  choose_kinds(cloud);
  // Only derivatives count. They do not depend on the positions read, and on the orientations read
  // only as far as these lie off the model.
  for (const std::vector<int>& rows : sessions) {
    if (!given.has_orientation()) break;
    const Robot there = robot_at_row(cloud.robot, given, rows.front());
    const ChainEvaluator evaluator(there.chain);
    for (int row : rows) cloud.given.orientation[row] = evaluator.pose(given.q[row]).rotation;
  }

  if (cloud.options.needs_sights()) find_places(cloud);
  cloud.poses = random_poses(cloud, kCloudSize, options.seed);
  cloud.noise = sigma_of(cloud, readings(cloud, cloud.poses));
  // The given poses may show parameters that no pose in the box does.
  cloud.unknowns = choose_identifiable(cloud.robot, readings(cloud, with_given(cloud))).kept;
  if (cloud.unknowns.empty())
    throw std::invalid_argument(
        "no pose shows any of the parameters that 'identify' of the robot allows; allow others, or "
        "measure orientations too");
  return cloud;
}

std::vector<JointVector> configurations(const std::vector<PlannedPose>& poses) {
  std::vector<JointVector> all;
  for (const PlannedPose& pose : poses) all.push_back(pose.q);
  return all;
}

std::vector<PlannedPose> planned_poses(const std::vector<JointVector>& configurations) {
  std::vector<PlannedPose> all;
  for (const JointVector& q : configurations) all.push_back({q, "", ""});
  return all;
}

namespace {

// Random configurations above the floor in which something can be read.
std::vector<PlannedPose> random_sighted(const PoseCloud& cloud, int count, std::uint64_t seed) {
  constexpr int kMostDraws = 32;  // of a configuration
  const KinematicChain& chain = cloud.robot.chain;
  for (int draws = 1; draws <= kMostDraws; draws *= 2) {
    std::vector<PlannedPose> poses = random_sighted_poses(
        chain, sights_of(cloud.options, chain, cloud.touches), draws * count, seed);
    std::erase_if(poses, [&](const PlannedPose& pose) { return !is_above_floor(cloud, pose.q); });
    if (std::ssize(poses) < count) continue;
    poses.resize(count);
    return poses;
  }
  throw std::invalid_argument(
      "hardly any configuration in which something is touched or read keeps links and tool above "
      "the floor; check the places of contacts, beams, cameras and boards, or lower the floor "
      "(--floor-mm)");
}

}  // namespace

std::vector<PlannedPose> random_poses(const PoseCloud& cloud, int count, std::uint64_t seed) {
  const CloudOptions& options = cloud.options;
  if (options.needs_sights()) return random_sighted(cloud, count, seed);
  std::vector<JointVector> all;
  for (int draws = 2; draws <= kDrawsPerConfiguration; draws *= 2) {
    all = random_configurations(cloud.robot, draws * count, options.box, seed);
    std::vector<JointVector> above = all;
    std::erase_if(above, [&](const JointVector& q) { return !is_above_floor(cloud, q); });
    if (std::ssize(above) < count) continue;
    above.resize(count);
    return planned_poses(above);
  }
  fail_below_floor(cloud.robot, all);
}

std::vector<PlannedPose> with_given(const PoseCloud& cloud) {
  std::vector<PlannedPose> all = cloud.poses;
  std::vector<bool> is_in(cloud.given.pose_ids.size(), false);
  for (int row = 0; row < cloud.given.rows(); ++row)
    if (!is_in[cloud.given.pose[row]]) {
      is_in[cloud.given.pose[row]] = true;
      all.push_back(planned_pose_at(cloud.given, row));
    }
  return all;
}

Eigen::MatrixXd given_derivatives(const PoseCloud& cloud, const Robot& robot) {
  const SessionModels models(cloud.given, robot, cloud.unknowns, sigma_of(cloud, cloud.given));
  std::vector<Eigen::MatrixXd> factors;
  for (int s = 0; s < models.sessions(); ++s) {
    const ObservationModel& model = models.model(s);
    factors.push_back(
        fold(model.at(Eigen::VectorXd::Zero(model.unknowns())), model, ReadingLaw{}).factor);
  }
  const Eigen::MatrixXd factor = models.join(factors);
  const int last = models.sessions() - 1, kept = models.model(0).unknowns();
  if (last == 0) return factor.topLeftCorner(kept, kept);

  // Columns of the eliminated unknowns first, then of the kept ones: the end of the triangle
  // belongs to the kept ones after elimination.
  const int fitted = models.unknowns() - kept;
  Eigen::MatrixXd columns(factor.rows(), models.unknowns());
  columns << factor.middleCols(kept, fitted), factor.leftCols(kept);
  const std::vector<int>& own = models.own(last);
  for (int i = 0; i < std::ssize(own); ++i) {
    const auto place = std::find(cloud.unknowns.begin(), cloud.unknowns.end(), own[i]);
    if (place == cloud.unknowns.end()) continue;
    const auto k = static_cast<int>(place - cloud.unknowns.begin());
    columns.col(models.first_own(last) - kept + i).swap(columns.col(fitted + k));
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::MatrixXd triangle =
      qr.matrixQR().topRows(columns.cols()).triangularView<Eigen::Upper>();
  return triangle.bottomRightCorner(kept, kept);
}

Campaign points(const PoseCloud& cloud, const std::vector<JointVector>& configurations) {
  const KinematicChain& chain = cloud.robot.chain;
  const ChainEvaluator evaluator(chain);
  const int targets = target_count(chain), anchors = anchor_count(chain);
  Campaign campaign;
  campaign.source = "the poses to be planned";
  for (const Target& target : chain.targets) campaign.target_names.push_back(target.name);
  for (int pose = 0; pose < std::ssize(configurations); ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose + 1));
    const Pose frame = evaluator.pose(configurations[pose]);
    for (int channel = 0; channel < std::max(1, targets) * std::max(1, anchors); ++channel) {
      campaign.pose.push_back(pose);
      campaign.q.push_back(configurations[pose]);
      campaign.position.push_back(frame.translation);
      if (targets > 0) campaign.target.push_back(channel % targets);
    }
  }
  return campaign;
}

Eigen::MatrixXd equal_blocks(const Campaign& readings, const Eigen::MatrixXd& rows) {
  std::vector<int> count(readings.pose_ids.size(), 0);
  for (int pose : readings.pose) ++count[pose];
  const Eigen::Index size = readings.reading_size().all();
  const Eigen::Index block = size * *std::ranges::max_element(count);
  if (block * std::ssize(count) == rows.rows()) return rows;
  Eigen::MatrixXd blocks = Eigen::MatrixXd::Zero(block * std::ssize(count), rows.cols());
  std::vector<int> filled(count.size(), 0);
  for (int row = 0; row < readings.rows(); ++row) {
    const int pose = readings.pose[row];
    blocks.middleRows(pose * block + size * filled[pose]++, size) =
        rows.middleRows(row * size, size);
  }
  return blocks;
}

}  // namespace armtrue
