#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The geometry of a robot, calibrated to at most 500 readings of a campaign, evenly chosen, by
/// plain least squares: a heavy-tailed law would take the smaller of two parts for blunders. Of
/// images at most 100 of each camera and board, with 12 corners each, whose ids may be wrong: the
/// law is heavy-tailed, and reading_equations() leave these corners out.
struct PlainFit {
  Campaign readings;
  CalibrationResult result;

  double poses() const;  ///< that the readings are of
};

/// Nothing if the readings are too few.
std::optional<PlainFit> fit_plainly(const Robot& robot, const Campaign& campaign);

/// The same with another fit in its place, effects included, which stay as they are.
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

/// The same where all rows of an image are one reading. With O the derivatives of its corners by
/// the six numbers of where the board is, its equations are Q^T of theirs, Q an orthonormal basis
/// of the columns of O: six numbers, which are all that an image says of the pose of an arm.
/// Corners that contradict the others of their image take no part.
FitEquations reading_equations(const PlainFit& fit, const std::vector<int>& further_parameters);

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

/// Fall of BIC by these unknowns, the best of so many `choices`; 0 where the readings of so many
/// poses leave no freedom for them. Of few readings chance explains nearly all by as many unknowns
/// as they have freedom: what is left of it counts.
double fall_of_bic(const JointFit& joint, const FitEquations& equations, double poses,
                   double choices);

/// A fall of BIC that is not chance.
inline constexpr double kClearFall = 20;

/// Whether the errors of most readings fall by what further unknowns explain (columns times value),
/// not only those of a few blunders.
bool is_of_most(const Eigen::VectorXd& explained, const FitEquations& equations);

/// The readings without which a fit is best, as blunders, and the fall of BIC without them.
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
