#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The geometry of a robot, calibrated by plain least squares to at most 500 readings of a
/// campaign, at equal steps: a heavy-tailed law would take the smaller of two parts for blunders.
/// Of images at most 100 of each camera and board, with 12 corners each, whose ids may be wrong:
/// the law is heavy-tailed, and reading_equations() leave these corners out.
struct PlainFit {
  Campaign readings;
  CalibrationResult result;

  double poses() const;  ///< that the readings are of
};

/// Nothing if the readings are too few.
std::optional<PlainFit> fit_plainly(const Robot& robot, const Campaign& campaign);

/// The same with the parameters that `robot` asks for, not all that the readings show.
std::optional<PlainFit> fit_as_asked(const Robot& robot, const Campaign& campaign);

/// The same with a given fit, whose effects stay as they are.
PlainFit beside_fit(const CalibrationResult& fit, const Campaign& campaign);

/// Whitened equations of a fit, and of further unknowns that were not fitted. Each session has a
/// base of its own among the fitted columns.
struct FitEquations {
  int row_size;                        ///< equations of a reading
  std::vector<std::vector<int>> rows;  ///< of PlainFit::readings that each reading is
  Eigen::MatrixXd basis;     ///< orthonormal, of all fitted columns
  Eigen::MatrixXd columns;   ///< of the further unknowns
  Eigen::VectorXd residual;  ///< orthogonal to the basis
};

FitEquations fit_equations(const PlainFit& fit, const std::vector<int>& further_parameters);

/// Changes of the fitted parameters (result.set.kept) that do to the readings, by least squares,
/// what `changes` of other parameters do. 0 for a parameter that each session has of its own.
Eigen::VectorXd like_changes(const PlainFit& fit, const std::vector<int>& parameters,
                             const Eigen::VectorXd& changes);

/// A column of FitEquations::columns, the equations of each reading times its factor.
Eigen::VectorXd times_of_rows(const Eigen::VectorXd& column, const Eigen::VectorXd& factors);

/// The same with all rows of an image as one reading. With O the derivatives of its corners by the
/// pose of the board and Q an orthonormal basis of the columns of O, its six equations are Q^T
/// times those of the corners: all that an image shows of the pose of an arm. Corners that
/// contradict the others of their image take no part.
FitEquations reading_equations(const PlainFit& fit, const std::vector<int>& further_parameters);

/// The rows of an image that agree on a place of the board: what the columns O of its place leave
/// of the residual with the smallest sum of sizes, which a few wrong corners do not bend, is like
/// that of the others. `place` and `residual` have all rows of which `rows` are numbers.
std::vector<int> agreeing_rows(const std::vector<int>& rows, const Eigen::MatrixXd& place,
                               const Eigen::VectorXd& residual);

/// Further unknowns that are fitted beside the others.
struct JointFit {
  double share = 0;       ///< of the squared residual that they explain
  Eigen::VectorXd value;  ///< of the unknowns
};

/// `columns`: of the further unknowns, such as some of FitEquations::columns in some of the rows.
JointFit fit_beside(const Eigen::MatrixXd& columns, const FitEquations& equations);
/// The same with the sums over the columns C known: C^T C, B^T C of the basis B, C^T residual.
JointFit fit_beside(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& on_basis,
                    const Eigen::VectorXd& slope, const FitEquations& equations);

/// Fall of BIC by these k unknowns, the best of so many `choices`. With f = poses * row_size -
/// columns of the basis it is
///     -(f - k) ln(1 - share) - k ln f - 2 ln choices.
/// 0 if f <= k. f - k, not f, because with few poses k unknowns explain nearly all by chance.
double fall_of_bic(const JointFit& joint, const FitEquations& equations, double poses,
                   double choices);

/// A fall of BIC that is not chance.
inline constexpr double kClearFall = 20;

/// Whether `explained` (columns times value) lowers the errors of most readings, not only those of
/// a few blunders.
bool is_of_most(const Eigen::VectorXd& explained, const FitEquations& equations);

/// The readings without which BIC is lowest, as blunders, and the fall of BIC.
struct Blunders {
  double score = 0;
  std::vector<int> rows{};  ///< of PlainFit::readings, ascending
};

/// Leaves out the worst reading, one after the other, while BIC falls. A blunder bends a plain fit,
/// and a change in a part of the readings may then straighten it: this is its rival.
Blunders find_blunders(const FitEquations& equations, double poses);

/// What a mistake of the readings may be, in words, and the fall of BIC without it.
struct Suspicion {
  double score = 0;
  std::string words;
};

}  // namespace armtrue
