#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The geometry of a robot, calibrated to at most 500 readings of a campaign, evenly chosen, by
/// plain least squares: a heavy-tailed law would take the smaller of two parts for blunders.
struct PlainFit {
  Campaign readings;
  CalibrationResult result;
};

/// Nothing if the readings are too few, or leave no more than the rounding of the file.
std::optional<PlainFit> fit_plainly(const Robot& robot, const Campaign& campaign);

/// Whitened equations of a fit, and of further unknowns that were not fitted.
struct FitEquations {
  int row_size;              ///< equations of a reading
  Eigen::MatrixXd basis;     ///< orthonormal, of all fitted columns
  Eigen::MatrixXd columns;   ///< of the further unknowns
  Eigen::VectorXd residual;  ///< orthogonal to the basis
};

FitEquations fit_equations(const PlainFit& fit, const std::vector<int>& further_parameters);

}  // namespace armtrue
