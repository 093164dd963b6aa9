#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "armtrue/calibration/zone.h"
#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

struct PlanOptions : CloudOptions {
  std::optional<Zone> zone;  ///< where the arm must be accurate; empty: everywhere
};

/// Expected quality of a geometric calibration from the given poses and some planned ones.
struct PlanQuality {
  double log_determinant;               ///< of M = J^T W J [SI]; -inf if rank-deficient
  std::array<double, 5> observability;  ///< O1 ... O5, see calibration.h
  /// Expected RMS error of the predicted position, three axes together [m]:
  /// sqrt(mean of tr(J_p M^-1 J_p^T)), J_p the position Jacobian; the mean over the candidates, and
  /// over the zone (0 without a zone). Infinite if M is rank-deficient.
  double cloud_deviation, zone_deviation;

  bool determines_all() const { return std::isfinite(cloud_deviation); }
};

/// Chooses poses for a geometric calibration by optimal design.
///
/// Each candidate of the cloud is a block of whitened derivatives of its readings. The planner
/// ignores the effects and priors of the robot. Each session of the given poses has its own base;
/// the planned poses continue the last session.
class PosePlanner {
 public:
  /// Throws std::invalid_argument as pose_cloud() does, and if no configuration has its point
  /// within the zone.
  PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given = {});

  /// Returns `count` different poses, at most kCloudSize. With M = J^T W J of the given
  /// and planned poses, the exchange search
  ///     without a zone maximises log det M (D-optimal; for robots Borm and Menq 1991),
  ///     with a zone minimises the mean of tr(J_p M^-1 J_p^T) over the zone (I-optimal).
  /// The same seed gives the same plan. Over the whole travel, random poses are nearly as good;
  /// planning helps for a zone, in a box, and if poses are few. Throws std::invalid_argument for a
  /// larger `count`.
  std::vector<PlannedPose> plan(int count) const;

  /// Random poses under the same limits, for comparison.
  std::vector<PlannedPose> random(int count, std::uint64_t seed) const;

  PlanQuality quality(const std::vector<PlannedPose>& poses) const;

  /// The smallest number of poses above `too_few` that determines all unknowns; nothing if no
  /// number does. Random poses are tried, because the choice of poses hardly matters for this.
  std::optional<int> fewest_that_determine(int too_few, std::uint64_t seed) const;

 private:
  std::vector<JointVector> zone_configurations() const;
  Eigen::MatrixXd position_triangle(const std::vector<JointVector>& configurations) const;

  std::optional<Zone> zone_;
  PoseCloud cloud_;

  // Upper triangular factors R over the unknowns; R^T R is:
  Eigen::MatrixXd given_;                           // the information of the given poses
  Eigen::MatrixXd cloud_position_, zone_position_;  // the mean of J^T J of the position [m]
};

}  // namespace armtrue
