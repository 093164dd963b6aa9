#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "armtrue/calibration/observation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Limits of the planned poses, and what is measured at them.
struct CloudOptions {
  /// Whether orientations are measured; false: positions only. If there are given poses, these
  /// decide. With targets or anchors, none are measured.
  bool orientation = true;
  std::optional<Box> box;  ///< of the measured point; absent: the whole travel of the joints
  double floor = 0;  ///< height in R_0 that no link origin and no point of the tool passes [m]
  std::uint64_t seed = 1;
};

/// The poses that a plan is chosen from: random configurations within the travel limits, above the
/// floor. Collisions are not checked. Each pose reads every target; with anchors, it reads the
/// distance of every target from every anchor.
struct PoseCloud {
  /// The robot without effects, and without targets and anchors if the given poses read none. Base
  /// and zero offsets are those of the last session of the given poses, which the planned poses
  /// continue; box and zone are in its R_A.
  Robot robot;
  CloudOptions options;
  Campaign given;      ///< poses already measured, with the orientations that the robot predicts
  ReadingSigma noise;  ///< the robot's; 0.1 mm and 0.1 mrad where it states none
  std::vector<JointVector> configurations;
  std::vector<int> unknowns;  ///< choose_identifiable() of the cloud and the given poses
};

inline constexpr int kCloudSize = 2000;

/// `given`: uses configurations, targets, sigmas and the values of drivers. Throws
/// std::invalid_argument if the box cannot be reached, hardly any configuration stays above the
/// floor, or no allowed parameter is identifiable.
PoseCloud pose_cloud(const Robot& robot, const CloudOptions& options, const Campaign& given = {});

/// Returns random configurations under the limits of the cloud.
std::vector<JointVector> random_poses(const PoseCloud& cloud, int count, std::uint64_t seed);

/// Returns the configurations of the cloud and of the given poses, each pose once.
std::vector<JointVector> with_given(const PoseCloud& cloud);

/// The predicted points of every target, once for each anchor; without noise and context.
Campaign points(const PoseCloud& cloud, const std::vector<JointVector>& configurations);

/// The predicted readings: points, or distances from the anchors, and orientations. Only their
/// derivatives are used.
Campaign readings(const PoseCloud& cloud, const std::vector<JointVector>& configurations);

/// A triangle R with R^T R = J^T J, J the whitened derivatives of the given poses with respect to
/// the unknowns of the cloud, then to the coefficients of the effects of `robot`. All sessions
/// count; the own parameters of all but the last are eliminated, because `unknowns` belong to the
/// last.
Eigen::MatrixXd given_derivatives(const PoseCloud& cloud, const Robot& robot);

/// Returns whether no link origin, point of the tool or target is below the height `floor` [m].
bool is_above(double floor, const Robot& robot, const JointVector& q);

}  // namespace armtrue
