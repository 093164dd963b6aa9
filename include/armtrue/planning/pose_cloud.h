#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

/// Limits of the planned poses, and what is measured at them. If poses are given, what is measured
/// is what was measured there.
struct CloudOptions : ReadingKinds {
  std::optional<Box> box;  ///< of the measured point; absent: the whole travel of the joints
  /// Height in R_0 that no link origin of the arm and no point of the tool passes [m]; absent: that
  /// of the robot. The origin of a prismatic link does not count: its axis has a direction and no
  /// place.
  std::optional<double> floor;
  std::uint64_t seed = 1;
};

std::vector<JointVector> configurations(const std::vector<PlannedPose>& poses);
/// Poses of these configurations, without touches and images.
std::vector<PlannedPose> planned_poses(const std::vector<JointVector>& configurations);

/// The poses that a plan is chosen from: random configurations within the travel limits, above the
/// floor. Collisions are not checked. If only an instrument reads, each pose reads every target,
/// with anchors the distance of every target from every anchor. Otherwise they are those of
/// random_sighted_poses(), in which all reads that can.
struct PoseCloud {
  /// The robot without effects, and without targets and anchors if the given poses read none. Base
  /// and zero offsets are those of the last session of the given poses, which the planned poses
  /// continue; box and zone are in its R_A.
  Robot robot;
  CloudOptions options;
  Campaign given;      ///< poses already measured, with the orientations that the robot predicts
  ReadingSigma noise;  ///< the robot's; 0.1 mm, 0.1 mrad, 0.2 px where it states none
  /// With images or several kinds of readings each row states its own noise: the median that given
  /// rows of its kind state, else these [m, px]. All are multiplied by the factor.
  double noise_length = 0, noise_pixel = 0, noise_factor = 1;
  std::map<ReadingKind, double> stated_noise;
  std::vector<PlannedPose> poses;
  std::vector<TouchSight> touches;   ///< what can be touched
  std::vector<int> unknowns;         ///< choose_identifiable() of the cloud and the given poses
};

inline constexpr int kCloudSize = 2000;

/// `given`: uses configurations, targets, sigmas and the values of drivers. Throws
/// std::invalid_argument if the box cannot be reached or is combined with touches, images or beams,
/// hardly any configuration stays above the floor, hardly any touches a contact, shows a board or
/// lets a beam read a plane, `given` has line profiles, or no allowed parameter is identifiable.
PoseCloud pose_cloud(const Robot& robot, const CloudOptions& options, const Campaign& given = {});

/// Random poses under the limits of the cloud.
std::vector<PlannedPose> random_poses(const PoseCloud& cloud, int count, std::uint64_t seed);

/// The poses of the cloud and the given ones, each pose once.
std::vector<PlannedPose> with_given(const PoseCloud& cloud);

/// The predicted points of every target, once for each anchor; without noise and context.
Campaign points(const PoseCloud& cloud, const std::vector<JointVector>& configurations);

/// Which corners of an image readings() has.
enum class Corners {
  all,
  some,  ///< at most twelve that span it, with the weight of all
};

/// What would be read there, without noise; only its derivatives count.
Campaign readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses,
                  Corners corners = Corners::some);

/// Standard deviation of the readings of a campaign, given ones or readings(), as
/// ObservationModel takes it.
ReadingSigma sigma_of(const PoseCloud& cloud, const Campaign& campaign);

/// Raises the noise to the spread of the given readings. Where nothing states a noise, the spread
/// replaces it, also if it is smaller.
void set_noise_by_spread(PoseCloud& cloud, const ReadingSigma& spread);

/// Rows of derivatives of readings(), equally many for each pose: rows of zeros are added to poses
/// with fewer.
Eigen::MatrixXd equal_blocks(const Campaign& readings, const Eigen::MatrixXd& rows);

/// A triangle R with R^T R = J^T J, J the whitened derivatives of the given poses with respect to
/// the unknowns of the cloud, then to the coefficients of the effects of `robot`. All sessions
/// count; the own parameters of all but the last are eliminated, because `unknowns` belong to the
/// last.
Eigen::MatrixXd given_derivatives(const PoseCloud& cloud, const Robot& robot);

/// Whether no link origin, point of the tool or target is below the floor of the cloud.
bool is_above_floor(const PoseCloud& cloud, const JointVector& q);

}  // namespace armtrue
