#include "armtrue/campaign/simulation.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/beam_sights.h"
#include "armtrue/campaign/sighted_poses.h"
#include "armtrue/campaign/views.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/joint_iterations.h"
#include "armtrue/statistics/random.h"
#include "campaign/random_joints.h"
#include "linear_algebra/decompositions.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

constexpr int kMaxSteps = 60;
constexpr double kDamping = 1e-3;  // [m^2]: near a singular posture the joints move little
constexpr double kReached = 1e-6;  // [m]

// A joint without limits has one turn here, as random configurations have; beyond_travel()
// lets it turn on.
bool within_travel(const KinematicChain& chain, const JointVector& q) {
  for (int j = 0; j < joint_count(chain); ++j)
    if (const auto [min, max] = travel(joint_link(chain, j)); q[j] < min || q[j] > max)
      return false;
  return !beyond_travel(chain, q);
}

bool inside(const Box& box, const Eigen::Vector3d& point) {
  return (point.array() >= box.low.array()).all() && (point.array() <= box.high.array()).all();
}

// The damped least-squares step of the joints for a position error of the point. kJoints: their
// number if known when compiled, otherwise Eigen::Dynamic.
template <int kJoints>
JointVector step_to(const KinematicChain& chain, const PoseJacobian& jacobian,
                    const Eigen::Vector3d& miss) {
  constexpr int kMost = kJoints == Eigen::Dynamic ? kMaxJoints : kJoints;
  Eigen::Matrix<double, 3, kJoints, 0, 3, kMost> joints(3, joint_count(chain));
  for (int j = 0; j < joints.cols(); ++j)
    joints.col(j) = joint_column(chain, jacobian, j).head<3>();
  return smallest_step(joints, miss, kDamping);
}

// The configuration, moved until its point is the wanted one; nothing if that is not reached within
// the travel.
std::optional<JointVector> moved_to(const ChainEvaluator& evaluator, const KinematicChain& chain,
                                    const Eigen::Vector3d& wanted, const JointVector& start) {
  const auto step_at = [&](const JointVector& q) -> std::optional<JointVector> {
    PoseJacobian jacobian;
    const Eigen::Vector3d miss = wanted - evaluator.pose(q, jacobian).translation;
    if (miss.norm() < kReached) return std::nullopt;
    return joint_count(chain) == 6 ? step_to<6>(chain, jacobian, miss)
                                   : step_to<Eigen::Dynamic>(chain, jacobian, miss);
  };
  const std::optional<JointVector> reached = newton(start, kMaxSteps, step_at);
  return reached && within_travel(chain, *reached) ? reached : std::nullopt;
}

}  // namespace

std::vector<JointVector> random_configurations(const Robot& robot, int count,
                                               const std::optional<Box>& box, std::uint64_t seed) {
  Random random(seed);
  const ChainEvaluator evaluator(robot.chain);
  std::vector<JointVector> configurations;
  constexpr int kTriesPerPose = 5000;
  int tries = 0;  // since the last that was found
  while (std::ssize(configurations) < count) {
    if (++tries > kTriesPerPose)
      throw std::invalid_argument(
          "the box cannot be reached within the travel limits; enlarge or move it");
    JointVector q = random_joints(robot.chain, random);
    if (box) {
      Eigen::Vector3d wanted;
      for (int i = 0; i < 3; ++i) wanted[i] = random.uniform(box->low[i], box->high[i]);
      const std::optional<JointVector> reached = moved_to(evaluator, robot.chain, wanted, q);
      if (!reached) continue;
      q = *reached;
      if (!inside(*box, evaluator.pose(q).translation)) continue;
    }
    if (beyond_travel(robot.chain, q)) continue;  // a joint that follows others
    configurations.push_back(q);
    tries = 0;
  }
  return configurations;
}

Campaign simulate(const Robot& robot, const Robot& truth, const SimulationOptions& options) {
  if (!options.images && !options.beams)
    return simulate(random_configurations(robot, options.poses, options.box, options.seed), truth,
                    options);
  std::vector<JointVector> commanded;
  for (const SightedPose& pose :
       random_sighted_poses(robot.chain, options.images ? Sensor::camera : Sensor::beam,
                            options.poses, options.seed))
    commanded.push_back(pose.q);
  return simulate(commanded, truth, options);
}

namespace {

// The visits of the poses, without readings.
Campaign visits(const std::vector<JointVector>& commanded, const Robot& truth,
                const SimulationOptions& options, Random& random) {
  const int poses = static_cast<int>(commanded.size());
  Campaign campaign;
  campaign.source = "simulated";
  for (int pose = 0; pose < poses; ++pose) campaign.pose_ids.push_back(std::to_string(pose + 1));
  for (const Target& target : truth.chain.targets) campaign.target_names.push_back(target.name);
  for (const Anchor& anchor : truth.chain.anchors) campaign.anchor_names.push_back(anchor.name);
  const int targets = std::max(1, target_count(truth.chain));
  const int anchors = std::max(1, anchor_count(truth.chain));

  double time = 0;
  std::vector<int> order(poses);
  for (int pose = 0; pose < poses; ++pose) order[pose] = pose;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    if (options.order == VisitOrder::random)
      shuffle(order, random.next());
    else
      std::stable_sort(order.begin(), order.end(),
                       [&](int a, int b) { return commanded[a][0] < commanded[b][0]; });
    for (int pose : order) {
      for (int channel = 0; channel < anchors * targets; ++channel) {
        campaign.pose.push_back(pose);
        campaign.repeat.push_back(repeat + 1);
        campaign.q.push_back(commanded[pose]);
        campaign.time_s.push_back(time);
        campaign.line.push_back(campaign.rows() + 1);
        if (!truth.chain.targets.empty()) campaign.target.push_back(channel % targets);
        if (!truth.chain.anchors.empty()) campaign.anchor.push_back(channel / targets);
      }
      time += options.seconds_per_visit;
    }
  }
  derive_arrival(campaign);
  return campaign;
}

// A reading of a camera or a beam.
struct Seen {
  int name = 0;  // of the corner or the plane
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double length = 0;  // of a beam [m]
};

// What can be seen, by its names in the campaign, and what is seen with the measured frame
// somewhere.
struct Sensors {
  std::vector<std::string> names;
  std::function<std::vector<Seen>(const Pose& a_from_measured)> read;
};

Sensors cameras_of(const KinematicChain& chain, const SimulationOptions& options, Random& random) {
  Sensors cameras;
  std::vector<std::pair<View, int>> corners;  // each name's, as its view and its point
  for (const View& view : views_of(chain)) {
    const std::vector<std::string> names = corner_names(chain, view);
    cameras.names.insert(cameras.names.end(), names.begin(), names.end());
    for (int point = 0; point < std::ssize(names); ++point) corners.emplace_back(view, point);
  }
  cameras.read = [&chain, &options, &random, corners](const Pose& measured) {
    std::vector<Seen> seen;
    for (int name = 0; name < std::ssize(corners); ++name) {
      const auto& [view, point] = corners[name];
      if (!shows(chain, view, measured, point, 0)) continue;
      Eigen::Vector2d pixel = pixel_of(chain, view, measured, point);
      for (double& value : pixel) value += options.noise_pixel * random.normal();
      if (random.uniform(0, 1) < options.blunders)
        pixel += random.uniform(2, 20) * random.normal3().head<2>().normalized();
      seen.push_back({.name = name, .pixel = pixel});
    }
    return seen;
  };
  return cameras;
}

Sensors beams_of(const KinematicChain& chain, const SimulationOptions& options, Random& random) {
  const std::vector<BeamSight> sights = beam_sights_of(chain);
  Sensors beams;
  for (const BeamSight& sight : sights) beams.names.push_back(sight.name);
  beams.read = [&chain, &options, &random, sights](const Pose& measured) {
    std::map<int, std::pair<double, int>> nearest;  // of each beam
    for (int k = 0; k < std::ssize(sights); ++k)
      if (const auto length = beam_reading_at(chain, sights[k], measured)) {
        const std::pair found(*length, k);
        const auto [known, is_new] = nearest.try_emplace(sights[k].beam, found);
        if (!is_new) known->second = std::min(known->second, found);
      }
    std::vector<Seen> seen;
    for (const auto& [beam, found] : nearest) {
      double length = found.first + options.noise_position * random.normal();
      if (random.uniform(0, 1) < options.blunders) length += random.uniform(2e-3, 20e-3);
      seen.push_back({.name = found.second, .length = length});
    }
    return seen;
  };
  return beams;
}

// What cameras or beams read at the visits, one after the other.
Campaign read_at(const std::vector<JointVector>& commanded, Robot truth,
                 const SimulationOptions& options, Random& random) {
  truth.chain.targets.clear();
  truth.chain.anchors.clear();
  const Campaign stops = visits(commanded, truth, options, random);
  const Sensors sensors = options.images ? cameras_of(truth.chain, options, random)
                                         : beams_of(truth.chain, options, random);
  const RobotModel model(truth);
  std::vector<int> rows;
  std::vector<Seen> all;
  for (int row = 0; row < stops.rows(); ++row)
    for (const Seen& seen : sensors.read(model.pose(stops.context(row)))) {
      rows.push_back(row);
      all.push_back(seen);
    }
  Campaign campaign = stops.select(rows);
  campaign.contact_names = sensors.names;
  if (options.images) campaign.metre_per_pixel = 1;
  for (const Seen& seen : all) {
    if (options.images) campaign.position.emplace_back(seen.pixel.x(), seen.pixel.y(), 0);
    campaign.distance.push_back(seen.length);
    campaign.touch.push_back({seen.name, -1, options.images});
  }
  return campaign;
}

}  // namespace

Campaign simulate(const std::vector<JointVector>& commanded, const Robot& truth,
                  const SimulationOptions& options) {
  Random random(options.seed ^ 0x9e3779b97f4a7c15ULL);
  if (options.images || options.beams) return read_at(commanded, truth, options, random);
  // The visits first: an effect may depend on the direction of arrival.
  Campaign campaign = visits(commanded, truth, options, random);
  const RobotModel model(truth);
  for (int row = 0; row < campaign.rows(); ++row) {
    const Context context = campaign.context(row);
    const int target = campaign.target.empty() ? -1 : campaign.target[row];
    if (!campaign.anchor.empty()) {
      double distance = model.distance(context, target, campaign.anchor[row]) +
                        options.noise_position * random.normal();
      if (random.uniform(0, 1) < options.blunders) distance += random.uniform(2e-3, 20e-3);
      campaign.distance.push_back(distance);
      continue;
    }
    const Pose frame = model.pose(context);
    Eigen::Vector3d point =
        model.point(context, target) + options.noise_position * random.normal3();
    if (random.uniform(0, 1) < options.blunders) {
      const Eigen::Vector3d direction = random.normal3().normalized();
      point += random.uniform(2e-3, 20e-3) * direction;
    }
    campaign.position.push_back(point);
    if (options.orientation && truth.chain.targets.empty())
      campaign.orientation.emplace_back(Eigen::Matrix3d(
          rotation_exp(options.noise_orientation * random.normal3()) * frame.rotation));
  }
  return campaign;
}

}  // namespace armtrue
