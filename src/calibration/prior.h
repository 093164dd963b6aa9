#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/effects/robot.h"
#include "calibration/session_models.h"

namespace armtrue {

/// Prior knowledge of an unknown x as one more equation, (start + x) / deviation = 0: a normal law
/// about the expected value, from which the given robot is `start` away.
struct Prior {
  int unknown;       ///< index
  double deviation;  ///< [SI]
  double start = 0;  ///< [SI]
  int curve = -1;    ///< number of the effect among those that are curves; -1: of none

  double residual(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return (start + x[unknown]) / deviation;
  }
};

/// The priors of a fit, all of unknowns of the first session:
/// - parameters named in `robot.priors`: about the nominal value;
/// - coefficients of a curve (a series of three or more): about 0, all with one deviation, which
///   update_curves() finds;
/// - other coefficients: about 0, with the deviation at which the effect moves its parameter by
///   5 mm or 5 mrad RMS over the rows. No effect is larger, and without this bound a coefficient
///   that the poses do not show would run away.
std::vector<Prior> priors_of(const Robot& robot, const SessionModels& models);

/// Adds the information of the priors, 1 / deviation^2 on the diagonal, to that of the readings.
void add_priors(const std::vector<Prior>& priors, Eigen::MatrixXd& information);

struct CurveUpdate {
  bool settled = true;      ///< no deviation changed by 10 % or more
  double undetermined = 0;  ///< number of coefficients that the priors, not the readings, determine
};

/// Sets the deviation of each curve to the one that makes the readings most likely (empirical
/// Bayes; MacKay, "Bayesian interpolation", 1992): with c_k the coefficients, V_k their variances
/// and s the deviation so far,
///     gamma = sum_k (1 - V_k / s^2),    s_new^2 = sum_k c_k^2 / gamma;
/// gamma is the number of coefficients that the readings determine. `factor`: of the fold at x.
CurveUpdate update_curves(const Eigen::MatrixXd& factor, const Eigen::VectorXd& x,
                          std::vector<Prior>& priors);

}  // namespace armtrue
