#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot_model.h"

namespace armtrue {

/// Spread of the readings about the model, per axis, one standard deviation.
struct ReadingSigma {
  double position = 1;     ///< [m]
  double orientation = 1;  ///< [rad]
};

/// Of a robot: as many as it has.
inline constexpr int kAllEffects = std::numeric_limits<int>::max();

/// The robot's target that each of the campaign's target names stands for, as indices. Throws
/// std::invalid_argument, with file and line, if the robot does not have it.
std::vector<int> match_targets(const Campaign& campaign, const KinematicChain& chain);

/// The robot's anchor that each of the campaign's anchor names stands for, as indices; just the
/// only anchor where the campaign names none. -1, -2, -3 for the axes that coordinates are along.
/// Empty unless distances were measured. Throws
/// std::invalid_argument, with file and line, if the robot does not have the anchor.
std::vector<int> match_anchors(const Campaign& campaign, const KinematicChain& chain);

/// Readings in one R_A against the model of one robot:
/// residuals, measured minus model, and the model's derivatives, divided by the standard deviation
/// of each reading so that position and orientation can stand in one sum of squares.
///
/// The unknowns x are changes from the robot given: of the chosen geometric parameters, then of the
/// coefficients of its effects, of the first `fitted_effects` of them. Rotations of base and tool
/// compose as exp(x_r) R.
class ObservationModel {
 public:
  /// `geometric`: parameter indices. Rows with a `sigma_mm` or `sigma_deg` of their own keep their
  /// ratio to `scale` (taken as the standard deviation of a row whose own sigma is the median).
  /// `common_from_own`: the R_A that points, orientations and base are in, from that of the
  /// instrument, which stands at its origin and has the anchors in it.
  ObservationModel(const Campaign& campaign, const Robot& robot, std::vector<int> geometric,
                   const ReadingSigma& scale, int fitted_effects = kAllEffects,
                   const Pose& common_from_own = {});

  int rows() const { return campaign_.rows(); }
  int row_size() const { return campaign_.reading_size().all(); }
  int unknowns() const { return geometric_count() + coefficient_count_; }
  int fitted_effects() const { return fitted_effects_; }
  int geometric_count() const { return static_cast<int>(geometric_.size()); }
  const std::vector<int>& geometric() const { return geometric_; }
  const Campaign& campaign() const { return campaign_; }
  /// Robot and campaign names for each unknown: `A2.d`, `joint compliance A2.theta c`.
  std::vector<std::string> unknown_names() const;

  /// Mean square, over the rows, of what a coefficient of the effects is multiplied by.
  double mean_square_value(int coefficient) const;

  /// The robot at x.
  Robot robot_at(const Eigen::VectorXd& x) const;

  /// A model of the same readings at one value of x, for reading rows from several threads.
  class At;
  At at(const Eigen::VectorXd& x) const;

  const ReadingSigma& scale() const { return scale_; }
  void set_scale(const ReadingSigma& scale) { scale_ = scale; }
  /// Standard deviations of one row: position [m], orientation [rad].
  ReadingSigma row_scale(int row) const;

 private:
  friend class At;
  void evaluate_effect_values(const Robot& robot);
  Eigen::Vector3d turn_of(const Eigen::VectorXd& x, int first_parameter) const;
  int anchor_of(int row) const {
    return anchors_[campaign_.anchor.empty() ? 0 : campaign_.anchor[row]];
  }

  const Campaign& campaign_;
  Robot robot_;
  std::vector<int> geometric_;
  std::vector<int> targets_;  // the campaign's targets as indices into the robot's; empty if none
  std::vector<int> anchors_;  // see match_anchors
  std::vector<BoundEffect> effects_;
  std::vector<int> first_coefficient_, first_value_;
  int coefficient_count_ = 0;      // of those that are fitted
  Eigen::MatrixXd effect_values_;  // values x rows
  ReadingSigma scale_;
  int fitted_effects_;
  Pose common_from_own_;
  double median_sigma_position_ = 0, median_sigma_orientation_ = 0;
};

class ObservationModel::At {
 public:
  /// The residual of one row, in R_A: measured minus model, [m], and [rad] as the rotation vector
  /// of measured * model^-1 (zero without orientations). Of a distance the first component, the
  /// others zero. Not whitened.
  Eigen::Matrix<double, 6, 1> residual(int row) const;

  /// Writes the whitened block of one row: row_size() x (unknowns() + 1), the derivatives of the
  /// model in the first columns, the residual in the last.
  void block(int row, Eigen::Ref<Eigen::MatrixXd> out) const;

 private:
  friend class ObservationModel;
  At(const ObservationModel& model, const Eigen::VectorXd& x);
  void offsets(int row, ParameterOffsets& offsets, double& scale) const;
  // A row as the model sees it.
  struct Prediction {
    Pose frame;                 // R_A from the measured frame, its origin at the target
    Eigen::Vector3d position;   // what the scale multiplies: the point from the instrument, or the
                                // distance first
    Eigen::Vector3d direction;  // of a distance: from the anchor, or along the axis, unit
    double scale;
  };
  Prediction predict(int row, PoseJacobian* jacobian) const;
  Eigen::Matrix<double, 6, 1> residual(int row, const Prediction& predicted) const;

  const ObservationModel& model_;
  Robot robot_;
  ChainEvaluator chain_;
  Eigen::Matrix3d base_turn_, tool_turn_;  // d(turn in R_A)/d(unknown turn)
};

}  // namespace armtrue
