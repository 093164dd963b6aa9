#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "armtrue/calibration/zone.h"
#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

struct PlanOptions : CloudOptions {
  std::optional<Zone> zone;  ///< where the arm shall be accurate; absent: everywhere
};

/// What a geometric calibration from some poses, with those given, promises.
struct PlanQuality {
  double log_determinant;               ///< of the information matrix [SI]; -inf: rank is missing
  std::array<double, 5> observability;  ///< O1 ... O5, as in CalibrationResult
  /// Expected deviation of the predicted position from the true one, three axes together [m]: root
  /// of its mean square over the cloud of candidates, and over the zone (0 without a zone).
  /// Infinite where rank is missing.
  double cloud_deviation, zone_deviation;
};

/// Chooses the poses from which a geometric calibration is best.
///
/// Every candidate of the cloud is a block of whitened derivatives of its readings. The robot's
/// effects and priors are left out. Given poses of several sessions have each a base of their own;
/// the planned ones continue the last.
class PosePlanner {
 public:
  /// Throws std::invalid_argument as pose_cloud() does, and if no configuration has its point
  /// within the zone.
  PosePlanner(const Robot& robot, const PlanOptions& options, const Campaign& given = {});

  /// `count` different configurations, at most kCloudSize, that with the given poses make
  /// the determinant of the information matrix largest (D-optimal) or, with a zone, the mean
  /// variance of the position predicted in it smallest (I-optimal), by exchange; for robots Borm
  /// and Menq 1991. The same for the same seed. Random poses all over the travel are nearly as good
  /// for all of it; planning pays for a zone, in a box, and where poses are few.
  std::vector<JointVector> plan(int count) const;

  /// Random configurations under the same limits, for comparison.
  std::vector<JointVector> random(int count, std::uint64_t seed) const;

  PlanQuality quality(const std::vector<JointVector>& configurations) const;

 private:
  std::vector<JointVector> zone_configurations() const;
  Eigen::MatrixXd triangle(const Campaign& campaign) const;
  Eigen::MatrixXd position_triangle(const std::vector<JointVector>& configurations) const;

  std::optional<Zone> zone_;
  PoseCloud cloud_;

  // Upper triangles R; R^T R is, over the unknowns, ...
  Eigen::MatrixXd typical_;                         // the information of an average pose
  Eigen::MatrixXd given_;                           // the information of the given poses
  Eigen::MatrixXd cloud_position_, zone_position_;  // the mean of J^T J of the position [m]
};

}  // namespace armtrue
