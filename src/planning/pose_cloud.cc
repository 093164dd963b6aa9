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
#include "armtrue/campaign/sighted_poses.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/contacts.h"
#include "armtrue/observation/fold.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"
#include "planning/image_poses.h"
#include "planning/touch_poses.h"

namespace armtrue {
namespace {

constexpr double kUsualPositionNoise = 1e-4;     // m
constexpr double kUsualOrientationNoise = 1e-4;  // rad
constexpr double kUsualPixelNoise = 0.2;         // px
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

PoseCloud pose_cloud(const Robot& robot, const CloudOptions& options, const Campaign& given) {
  if (given.has_profiles())
    throw std::invalid_argument(
        given.source +
        ": poses of line profiles are not planned; choose them by hand: many postures, all tilts "
        "and distances at which the sensor reads, three planes or a sphere");
  PoseCloud cloud{robot, options, given, {}, {}, {}, {}};
  const std::vector<std::vector<int>> sessions = rows_by_session(given);
  if (given.rows() > 0) cloud.robot = robot_at_row(robot, given, sessions.back().front());
  cloud.robot.sessions = robot.sessions;
  cloud.robot.effects.clear();
  cloud.noise = {robot.noise.position > 0 ? robot.noise.position : kUsualPositionNoise,
                 robot.noise.orientation > 0 ? robot.noise.orientation : kUsualOrientationNoise};
  if (given.rows() > 0) {  // what is planned is read as what is given
    cloud.options.orientation = given.has_orientation();
    if (given.target_names.empty()) cloud.robot.chain.targets.clear();
    if (!given.has_distances()) cloud.robot.chain.anchors.clear();
  } else if (!robot.chain.targets.empty() || !robot.chain.anchors.empty()) {
    cloud.options.orientation = false;
  }
  // Only derivatives count. They do not depend on the positions read, and on the orientations read
  // only as far as these lie off the model.
  for (const std::vector<int>& rows : sessions) {
    if (!given.has_orientation()) break;
    const Robot there = robot_at_row(cloud.robot, given, rows.front());
    const ChainEvaluator evaluator(there.chain);
    for (int row : rows) cloud.given.orientation[row] = evaluator.pose(given.q[row]).rotation;
  }

  cloud.options.images = given.rows() > 0 ? given.has_pixels() : options.images;
  cloud.options.beams = given.rows() > 0 ? given.has_beams_only() : options.beams;
  cloud.options.touches =
      given.rows() > 0 ? given.has_touches() && !given.has_pixels() && !given.has_beams_only()
                       : options.touches;
  if (cloud.options.images || cloud.options.beams) {
    if (options.box)
      throw std::invalid_argument(
          std::string("a box limits poses in free space; where a ") +
          (cloud.options.images ? "camera sees a board" : "beam reads a plane") +
          ", their places say where");
    cloud.options.orientation = false;
    if (given.rows() == 0) {  // given readings may be of targets and anchors, too
      cloud.robot.chain.targets.clear();
      cloud.robot.chain.anchors.clear();
    } else {
      cloud.robot = with_contacts_fitted(std::move(cloud.robot), given, FitContacts::unknown);
    }
    if (cloud.options.beams) state_ranges(given, cloud.robot.chain);
  } else if (cloud.options.touches) {
    if (options.box)
      throw std::invalid_argument(
          "a box limits poses in free space; where contacts are touched, the contacts say where");
    cloud.options.orientation = false;
    cloud.robot = with_contacts_fitted(std::move(cloud.robot), given, FitContacts::unknown);
    cloud.touches = touches_to_plan(cloud.robot, given);
  }
  cloud.poses = random_poses(cloud, kCloudSize, options.seed);
  if (cloud.options.images)
    cloud.noise.position = (robot.noise.pixel > 0 ? robot.noise.pixel : kUsualPixelNoise) *
                           readings(cloud, cloud.poses).metre_per_pixel;
  // A box may leave unseen what the given poses show.
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

// Random configurations in which a camera or a beam reads, above the floor; may be fewer.
std::vector<PlannedPose> random_sighted(const PoseCloud& cloud, int count, std::uint64_t seed) {
  constexpr int kMostDraws = 8;  // of a configuration: half of them and more are above the floor
  const Sensor sensor = cloud.options.images ? Sensor::camera : Sensor::beam;
  std::vector<PlannedPose> poses;
  for (int draws = 1; draws <= kMostDraws && std::ssize(poses) < count; draws *= 2) {
    poses.clear();
    for (const SightedPose& pose :
         random_sighted_poses(cloud.robot.chain, sensor, draws * count, seed))
      if (std::ssize(poses) < count && is_above_floor(cloud, pose.q))
        poses.push_back({pose.q, pose.name, ""});
  }
  return poses;
}

std::string too_few_that_read(const CloudOptions& options) {
  const auto [which, places] =
      options.images ? std::pair("that shows a board keeps links and tool", "cameras and boards")
      : options.beams
          ? std::pair("in which a beam reads a plane keeps links and tool", "beams and planes")
          : std::pair("touches a contact with links and tool within their travel and",
                      "the contacts");
  return fmt::format(
      "hardly any configuration {} above the floor; check the places of {}, or lower the floor "
      "(--floor-mm)",
      which, places);
}

}  // namespace

std::vector<PlannedPose> random_poses(const PoseCloud& cloud, int count, std::uint64_t seed) {
  const CloudOptions& options = cloud.options;
  if (options.images || options.beams || options.touches) {
    std::vector<PlannedPose> poses =
        options.touches ? random_touches(cloud, count, seed) : random_sighted(cloud, count, seed);
    if (std::ssize(poses) == count) return poses;
    throw std::invalid_argument(too_few_that_read(options));
  }
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
  if (cloud.options.touches || cloud.options.beams) {
    const std::vector<PlannedPose> given = given_touches(cloud);
    all.insert(all.end(), given.begin(), given.end());
    return all;
  }
  std::vector<bool> is_in(cloud.given.pose_ids.size(), false);
  for (int row = 0; row < cloud.given.rows(); ++row)
    if (!is_in[cloud.given.pose[row]]) {
      is_in[cloud.given.pose[row]] = true;
      all.push_back({cloud.given.q[row], "", ""});
    }
  return all;
}

Eigen::MatrixXd given_derivatives(const PoseCloud& cloud, const Robot& robot) {
  const SessionModels models(cloud.given, robot, cloud.unknowns, cloud.noise);
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

Campaign readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses) {
  if (cloud.options.images) return image_readings(cloud, poses);
  if (cloud.options.touches || cloud.options.beams) return touch_readings(cloud, poses);
  const KinematicChain& chain = cloud.robot.chain;
  Campaign campaign = points(cloud, configurations(poses));
  const int targets = std::max(1, target_count(chain));
  const int anchors = anchor_count(chain);
  if (anchors > 0) {
    for (const Anchor& anchor : chain.anchors) campaign.anchor_names.push_back(anchor.name);
    for (int row = 0; row < campaign.rows(); ++row)
      campaign.anchor.push_back(row / targets % anchors);
    campaign.position.clear();
    campaign.distance.assign(campaign.q.size(), 1.0);  // only derivatives count
  }
  if (cloud.options.orientation) {
    const ChainEvaluator evaluator(chain);
    for (const JointVector& q : campaign.q)
      campaign.orientation.emplace_back(evaluator.pose(q).rotation);
  }
  return campaign;
}

}  // namespace armtrue
