#include "armtrue/campaign/simulation.h"

#include <Eigen/Core>
#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/campaign/touch_sights.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/approach.h"
#include "armtrue/statistics/random.h"
#include "campaign/random_joints.h"
#include "campaign/simulated_readings.h"
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

ReadingKinds with_usual_kind(ReadingKinds kinds, const KinematicChain& chain) {
  if (kinds.count() == 0) (chain.anchors.empty() ? kinds.points : kinds.distances) = true;
  kinds.orientation =
      kinds.orientation && kinds.points && kinds.count() == 1 && chain.targets.empty();
  return kinds;
}

std::vector<std::vector<Sight>> sights_of(const ReadingKinds& kinds, const KinematicChain& chain,
                                          const std::vector<TouchSight>& touches) {
  std::vector<std::vector<Sight>> sights;
  if (kinds.images) sights.push_back(sights_of_boards(chain));
  if (kinds.touches) sights.push_back(sights_of_touches(chain, touches));
  if (kinds.beams) sights.push_back(sights_of_beams(chain));
  if (kinds.profiles) sights.push_back(sights_of_scanner(chain, *kinds.profiles));
  if (kinds.points || kinds.distances) sights.push_back(sights_of_instrument());
  return sights;
}

Campaign simulate(const Robot& robot, const Robot& truth, const SimulationOptions& options) {
  if (!options.needs_sights())
    return simulate(random_configurations(robot, options.poses, options.box, options.seed), truth,
                    options);
  const KinematicChain& chain = robot.chain;
  const auto touches = options.touches ? touch_sights_of(chain) : std::vector<TouchSight>{};
  return simulate(
      random_sighted_poses(chain, sights_of(options, chain, touches), options.poses, options.seed),
      truth, options);
}

namespace {

// The visits of the poses, without readings.
Campaign visits(const std::vector<PlannedPose>& commanded, const SimulationOptions& options,
                Random& random) {
  const int poses = static_cast<int>(commanded.size());
  Campaign campaign;
  campaign.source = "simulated";
  for (int pose = 0; pose < poses; ++pose) campaign.pose_ids.push_back(std::to_string(pose + 1));
  double time = 0;
  std::vector<int> order(poses);
  for (int pose = 0; pose < poses; ++pose) order[pose] = pose;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    if (options.order == VisitOrder::random) shuffle(order, random.next());
    if (options.order == VisitOrder::sorted)
      std::stable_sort(order.begin(), order.end(),
                       [&](int a, int b) { return commanded[a].q[0] < commanded[b].q[0]; });
    for (int pose : order) {
      campaign.pose.push_back(pose);
      campaign.repeat.push_back(repeat + 1);
      campaign.q.push_back(commanded[pose].q);
      campaign.time_s.push_back(time);
      time += options.seconds_per_visit;
    }
  }
  derive_arrival(campaign);
  return campaign;
}

Robot without_instrument(Robot robot) {
  std::erase_if(robot.effects,
                [](const Effect& effect) { return effect.parameter.owner == Owner::instrument; });
  return robot;
}

// The joint angles, near those of the context, in which the arm touches, off by an error; nothing
// if that is out of reach.
std::optional<JointVector> touching(const RobotModel& model, const KinematicChain& chain,
                                    const TouchSight& sight, Context context,
                                    const ReadingErrors& errors) {
  const auto pose_at = [&](const JointVector& q, PoseJacobian& jacobian) {
    model.chain().pose(q, jacobian);
    context.q = q;
    return model.pose(context);
  };
  Eigen::VectorXd error;
  const auto miss = [&](const Eigen::Vector3d& place, Eigen::MatrixX3d& gradients) {
    Eigen::VectorXd off = off_surface(chain, sight, place, gradients);
    if (error.size() == 0) error = errors.of_touch(off.size());
    return Eigen::VectorXd(off - error);
  };
  return touching_joints(chain, pose_at, touching_point(chain, sight), miss, context.q);
}

// The readings with the columns of their stops.
Campaign joined(const Campaign& stops, const std::vector<int>& stop_of_row, Campaign read,
                bool has_images) {
  Campaign campaign = stops.select(stop_of_row);
  campaign.line.resize(campaign.q.size());
  std::iota(campaign.line.begin(), campaign.line.end(), 1);
  campaign.metre_per_pixel = has_images ? 1 : 0;
  campaign.position = std::move(read.position);
  campaign.distance = std::move(read.distance);
  campaign.touch = std::move(read.touch);
  campaign.contact_names = std::move(read.contact_names);
  campaign.profile = std::move(read.profile);
  campaign.target = std::move(read.target);
  campaign.target_names = std::move(read.target_names);
  campaign.anchor = std::move(read.anchor);
  campaign.anchor_names = std::move(read.anchor_names);
  campaign.orientation = std::move(read.orientation);
  campaign.sigma_position = std::move(read.sigma_position);
  number_profile_points(campaign);
  return campaign;
}

}  // namespace

Campaign simulate(const std::vector<PlannedPose>& commanded, const Robot& truth,
                  SimulationOptions options) {
  static_cast<ReadingKinds&>(options) = with_usual_kind(options, truth.chain);
  Random random(options.seed ^ 0x9e3779b97f4a7c15ULL);
  const ReadingErrors errors(options, random);
  // The visits first: an effect may depend on the direction of arrival.
  Campaign stops = visits(commanded, options, random);
  Campaign read;
  if (options.points || options.distances || options.touches)
    for (const Target& target : truth.chain.targets) read.target_names.push_back(target.name);
  if (options.distances)
    for (const Anchor& anchor : truth.chain.anchors) read.anchor_names.push_back(anchor.name);
  const std::vector<Instrument> instruments = instruments_of(truth, options, errors, read);
  const RobotModel model(without_instrument(truth));
  const auto touches = options.touches ? touch_sights_of(truth.chain) : std::vector<TouchSight>{};
  std::vector<int> stop_of_row;
  for (int stop = 0; stop < stops.rows(); ++stop) {
    Visit visit{stops.context(stop), {}, std::nullopt};
    if (const auto sight = touch_at(commanded[stops.pose[stop]], truth.chain, touches))
      if (const auto q = touching(model, truth.chain, *sight, visit.context, errors)) {
        stops.q[stop] = visit.context.q = *q;
        visit.touched = sight;
      }
    visit.a_from_measured = model.pose(visit.context);
    for (const Instrument& instrument : instruments)
      for (const ReadRow& row : instrument(visit)) {
        append_reading(row, truth, options, read);
        stop_of_row.push_back(stop);
      }
  }
  return joined(stops, stop_of_row, std::move(read), options.images);
}

Campaign simulate(const std::vector<JointVector>& commanded, const Robot& truth,
                  const SimulationOptions& options) {
  std::vector<PlannedPose> poses;
  for (const JointVector& q : commanded) poses.push_back({q, "", ""});
  return simulate(poses, truth, options);
}

}  // namespace armtrue
