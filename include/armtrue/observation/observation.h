#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/campaign/reading_sigma.h"
#include "armtrue/effects/line_of_sight.h"
#include "armtrue/effects/robot_model.h"

namespace armtrue {

/// The numbers of one reading: 1 or 3 of position, and 3 or none of orientation.
using NumbersOfRow = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

/// As the number of fitted effects: every effect of the robot.
inline constexpr int kAllEffects = std::numeric_limits<int>::max();

/// For each target name of the campaign, the index of the robot's target. Throws
/// std::invalid_argument, with file and line, if the robot does not have it.
std::vector<int> match_targets(const Campaign& campaign, const KinematicChain& chain);

/// For each anchor name of the campaign, the index of the robot's anchor; the robot's only anchor
/// if the campaign names none. Empty unless distances were measured. Throws std::invalid_argument,
/// with file and line, if the robot does not have the anchor.
std::vector<int> match_anchors(const Campaign& campaign, const KinematicChain& chain);

/// The contact, and the point of it, that a name in contact_names stands for.
struct ContactPoint {
  int contact = 0;  ///< index into the chain's contacts; of a pixel that of the camera
  int point = -1;   ///< index into the points of an artefact or a board; -1 of other kinds
  int board = -1;   ///< of a pixel: index into the chain's contacts
  int beam = -1;    ///< of the reading of a beam: index into the chain's contacts
};

/// For each contact name of the campaign, the contact and point. Throws std::invalid_argument, with
/// file and line, if the robot does not have it.
std::vector<ContactPoint> match_contacts(const Campaign& campaign, const KinematicChain& chain);

/// Prepares the touches of a campaign that was just read for a model: the touch of a point becomes
/// three rows, a pixel two, see Campaign::metre_per_pixel. Throws std::invalid_argument, with file
/// and line, if the robot does not have the contact, a gauge reads a point, camera and board are
/// both on the arm or both at rest, no image shows enough of a board, or the campaign has
/// sessions.
void bind_touches(Campaign& campaign, const KinematicChain& chain);

/// Readings in one R_A against the model of one robot: residuals, measured minus model, and the
/// model's derivatives, both divided by the standard deviation of each reading (whitened), so that
/// position and orientation can stand in one sum of squares.
///
/// The unknowns x are changes from the robot given: of the chosen geometric parameters, then of the
/// coefficients of the first `fitted_effects` of its effects. Rotations of base and tool compose as
/// exp(x_r) R.
///
/// With p the point in R_A that the model predicts for a row, o and e the origin and the axes of
/// the session's own R_A, a and z the place and zero error of the anchor, s the instrument's scale,
/// and w the shift of the point by errors of its range and its two angles (LineOfSight), the model
/// of a reading is
///     point         o + s (p - o) + w
///     coordinate    e_axis . (s (p - o) + w)
///     distance      s |p - a| + z
///     touch         f(C^T (p - c)) with c and C the place and the axes of the contact, and f(u)
///                       of a point      u_axis - b_axis, b the point of the artefact, or 0
///                       of a plane      n . (u - b) - radius, n its normal, z without an artefact
///                       of a sphere     |u - b| - ball - radius
///     beam          see beam_reading()
///     pixel         m project(K^T (q - k))_axis with q the point of the board in R_A, k and K the
///                       place and the axes of the camera, and m Campaign::metre_per_pixel; the
///                       arm moves the board or the camera
///     orientation   the rotation of the measured frame; its residual is log(measured * model^-1).
class ObservationModel {
 public:
  /// `geometric`: parameter indices. `sigma`: standard deviation of a row. If rows state a
  /// `sigma_mm` or `sigma_deg`, it is that of the row with their median, and the others keep their
  /// ratio to it. `common_from_own`: the R_A of points, orientations and base from the R_A of the
  /// instrument and the anchors. The campaign is not copied: it must outlive the model.
  ObservationModel(const Campaign& campaign, const Robot& robot, std::vector<int> geometric,
                   const ReadingSigma& sigma, int fitted_effects = kAllEffects,
                   const Pose& common_from_own = {});
  ObservationModel(const Campaign&& campaign, const Robot& robot, std::vector<int> geometric,
                   const ReadingSigma& sigma, int fitted_effects = kAllEffects,
                   const Pose& common_from_own = {}) = delete;

  int rows() const { return campaign_.rows(); }
  int row_size() const { return campaign_.reading_size().all(); }
  int unknowns() const { return geometric_count() + coefficient_count_; }
  int fitted_effects() const { return fitted_effects_; }
  int geometric_count() const { return static_cast<int>(geometric_.size()); }
  const std::vector<int>& geometric() const { return geometric_; }
  const Campaign& campaign() const { return campaign_; }
  /// Robot and campaign names for each unknown: `A2.d`, `joint compliance A2.theta c`.
  std::vector<std::string> unknown_names() const;

  /// The rows of each prediction, in the order of their first rows. Replicates are the rows of one
  /// pose whose joint angles, channel, stated noise and values of the effects are equal. They have
  /// the same derivatives; those of an orientation depend on its residual in second order.
  const GroupedRows& rows_by_prediction() const { return rows_by_prediction_; }
  bool has_replicates() const { return rows_by_prediction_.groups() < rows(); }
  /// The number of a row's prediction.
  int prediction_of(int row) const { return prediction_.empty() ? row : prediction_[row]; }

  /// Mean square over the rows of the value that multiplies a coefficient of the effects; if
  /// several values do, as for the lengths of arm.scale, the largest of their mean squares.
  double mean_square_value(int coefficient) const;

  /// The robot at x.
  Robot robot_at(const Eigen::VectorXd& x) const;

  /// The model at one value of x; several threads may read rows of it. The model must outlive it.
  class At;
  At at(const Eigen::VectorXd& x) const;

  const ReadingSigma& sigma() const { return sigma_; }
  void set_sigma(const ReadingSigma& sigma) { sigma_ = sigma; }
  /// Standard deviations of one row: position [m], orientation [rad].
  ReadingSigma row_sigma(int row) const;
  /// Multiplies `of_row` by Campaign::whitening, if the campaign has it. `of_row`: residual or
  /// derivatives, 3 or 6 x columns, each component divided by its standard deviation. With k_p and
  /// k_o the factors from stated standard deviations to sigma(), the covariance of a row is
  /// L diag(k_p^2, k_o^2) L^T, where L L^T is the one that it states.
  void whiten(int row, Eigen::Ref<Eigen::MatrixXd> of_row) const;
  /// The residual of a row, see At::residual(), divided by row_sigma() and white.
  NumbersOfRow whitened(int row, Eigen::Matrix<double, 6, 1> residual) const;

 private:
  friend class At;
  void evaluate_effect_values(const Robot& robot);
  void choose_columns();
  bool same_prediction(int row, int other) const;
  size_t hash_of_prediction(int row) const;
  void find_replicates();
  void require_bound(const Touch& touch) const;
  void require_placed(const Contact& contact) const;
  Eigen::Vector3d turn_of(const Eigen::VectorXd& x, int first_parameter) const;
  bool reads_beam(int row) const {
    return campaign_.kind(row) == ReadingKind::touch &&
           contacts_[campaign_.touch[row].contact].beam >= 0;
  }
  // Beams and cameras sit on the arm beside the targets: no target takes part in their readings.
  bool reads_target(int row) const {
    return campaign_.kind(row) != ReadingKind::pixel && !reads_beam(row);
  }
  int anchor_of(int row) const {
    return anchors_[campaign_.anchor.empty() ? 0 : campaign_.anchor[row]];
  }

  const Campaign& campaign_;
  Robot robot_;
  std::vector<int> geometric_;
  std::vector<int> targets_;  // the campaign's targets as indices into the robot's; empty if none
  std::vector<int> anchors_;  // see match_anchors
  // See match_contacts.
  std::vector<ContactPoint> contacts_;
  std::vector<BoundEffect> effects_;
  std::vector<int> first_coefficient_, first_value_;
  int coefficient_count_ = 0;      // of those that are fitted
  std::vector<int> columns_;       // of the Jacobian, those that the blocks need
  Eigen::MatrixXd effect_values_;  // values x rows
  GroupedRows rows_by_prediction_;
  std::vector<int> prediction_;  // number of each row's; empty without replicates
  ReadingSigma sigma_;
  int fitted_effects_;
  Pose common_from_own_;
  double median_sigma_position_ = 0, median_sigma_orientation_ = 0;  // 0: no row states any
};

class ObservationModel::At {
 public:
  /// The residual of one row, in R_A: measured minus model, [m], and [rad] as the rotation vector
  /// of measured * model^-1 (zero without orientations). The residual of a length (distance,
  /// coordinate, touch, beam or pixel) is the first component, the others are zero. Not whitened.
  Eigen::Matrix<double, 6, 1> residual(int row) const;

  /// Writes the whitened block of one row: row_size() x (unknowns() + 1), the derivatives of the
  /// model in the first columns, the residual in the last.
  void block(int row, Eigen::Ref<Eigen::MatrixXd> out) const;

  /// The same for consecutive rows from `first` on, a residual or a block for each;
  /// `out` of blocks has row_size() rows of each, in that order. Several rows are computed at once,
  /// see ChainEvaluator::poses(): they equal residual() and block() but for rounding.
  void residuals(int first, std::span<Eigen::Matrix<double, 6, 1>> out) const;
  void blocks(int first, int count, Eigen::Ref<Eigen::MatrixXd> out) const;

  /// The blocks of predictions, from number `first` on, see rows_by_prediction(): the residual is
  /// that of the first row. The derivatives J of replicates are those at an orientation residual of
  /// zero. J^T r is then the gradient of each reading: at its residual r it is J^T Jr^-T r, and
  /// Jr^-T r = r.
  void blocks_of_predictions(int first, int count, Eigen::Ref<Eigen::MatrixXd> out) const;

 private:
  friend class ObservationModel;
  At(const ObservationModel& model, const Eigen::VectorXd& x);
  // What the effects add to the parameters at a row.
  Eigen::VectorXd offsets(int row) const;
  LineOfSight line_of_sight(const Pose& frame) const;
  // The model's prediction of a row.
  struct Prediction {
    Pose frame;  // R_A from the measured frame, its origin at the target
    // From the origin of the measured frame to the target, to the point of a board, or to where a
    // beam ends, axes of R_A.
    Eigen::Vector3d lever{0, 0, 0};
    Eigen::Vector3d position;   // what the scale multiplies: of a point its place from the
                                // instrument; of a length that length, as the first component
    Eigen::Vector3d direction;  // unit; derivative of a length by the point
    double scale;
    Eigen::Vector3d off{0, 0, 0};  // shift of the position by errors of range and angles
    double zero = 0;               // error of a distance
    // Of a touch: the point in the axes of the contact, or of the camera, and the derivative of the
    // reading by it; of a beam where it ends.
    Eigen::Vector3d in_contact{0, 0, 0}, gradient{0, 0, 0};
    Intrinsics by_intrinsics;  // of a pixel, by those of its camera
  };
  // `jacobian`: that of the arm, or null.
  Prediction predict(int row, PoseJacobian* jacobian) const;
  // The same where R_A from the measured frame is known; `offset` is empty without effects.
  Prediction predict(int row, const Pose& a_from_measured, const Eigen::VectorXd& offset) const;
  // Calls take(k, row, prediction, Jacobian of the arm) for the row row_of(k) of each k < count;
  // without the Jacobian unless kWithJacobian.
  template <bool kWithJacobian, typename RowOf, typename Take>
  void for_each_prediction(int count, const RowOf& row_of, const Take& take) const;
  enum class Turn { by_residual, none };  // of the derivatives of an orientation
  template <typename Jacobian>
  void write_block(int row, const Prediction& predicted, Turn kind, Jacobian& jacobian,
                   Eigen::Ref<Eigen::MatrixXd> out) const;
  void predict_touch(int row, const Eigen::VectorXd& offset, Prediction& predicted) const;
  void predict_beam(int row, const Pose& measured, const Eigen::VectorXd& offset,
                    Prediction& predicted) const;
  void predict_pixel(int row, const Pose& measured, const Eigen::VectorXd& offset,
                     Prediction& predicted) const;
  Pose place_of(int contact, const Pose& measured, const Eigen::VectorXd& offset) const;
  double touch_column(int row, int parameter, const Prediction& predicted) const;
  double pixel_column(int row, int parameter, const Prediction& predicted) const;
  Eigen::Matrix<double, 6, 1> residual(int row, const Prediction& predicted) const;
  // The derivative of the position by a parameter that is none of the chain's, whitened by `sigma`.
  void set_instrument_column(int row, int parameter, const Prediction& predicted, double sigma,
                             Eigen::Ref<Eigen::VectorXd> column) const;

  const ObservationModel& model_;
  Robot robot_;
  ParameterLayout layout_;
  ChainEvaluator chain_;
  // offset[parameter] += coefficient * effect_values_(value, row)
  struct Term {
    double coefficient;
    int parameter, value;
  };
  std::vector<Term> terms_;                // of all effects
  std::vector<Prediction> predictions_;    // all, where some rows are replicates; else empty
  Eigen::Matrix3d base_turn_, tool_turn_;  // d(turn in R_A)/d(unknown turn)
  // d(turn in the axes of the contact)/d(unknown turn)
  std::vector<Eigen::Matrix3d> contact_turns_;
};

}  // namespace armtrue
