#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/observation/session_models.h"
#include "linear_algebra/sparse_cholesky.h"

namespace armtrue {

/// Prior knowledge of an unknown x as one more equation, (start + x) / deviation = 0: a normal
/// distribution about the expected value. `start`: value of the given robot minus the expected one.
struct Prior {
  int unknown;       ///< index
  double deviation;  ///< [SI]
  double start = 0;  ///< [SI]
  int width = -1;    ///< index of the width in Priors::widths that sets its deviation; -1: none
  double unit = 1;   ///< deviation = unit * that width

  double residual(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return (start + x[unknown]) / deviation;
  }
};

/// The prior standard deviation tau that several unknowns share; the readings help to choose it.
/// Its own prior is ln tau ~ N(ln typical, log_spread^2); with an infinite spread the readings
/// alone choose it.
struct PriorWidth {
  /// "lengths", "angles", "zero offsets", "errors of the instrument", "rest of the instrument"; the
  /// family; empty: of a curve
  std::string name;
  double typical;  ///< [SI]; of a family a factor of typical sizes
  double log_spread;
  double deviation;  ///< tau, in units of `typical`
};

struct Priors {
  std::vector<Prior> of_unknowns;
  std::vector<PriorWidth> widths;
};

/// The priors of a fit:
/// - parameters named in `robot.priors`: about the nominal value;
/// - unless `robot.free_links`, every other parameter of the links: about the nominal value
/// (Robot::nominal,
///   else that of `robot`), with the deviation that its class shares: lengths (d, r), angles
///   (alpha, beta and the theta of the last, fixed frame) and zero offsets (theta). Base, tool,
///   targets and anchors have none: nobody knows beforehand where they are;
/// - lasting errors of the instrument (instrument.range, .azimuth, .elevation, .point by anything
///   but time): about 0, with a common deviation of what they add to the readings; a distortion
///   beside others is their rest and has a smaller one of its own;
/// - coefficients of a family: about 0, with a common multiple of their typical sizes;
/// - coefficients of a curve (a series of three or more): about 0, all with one deviation;
/// - other coefficients: about 0, with the deviation at which the effect moves its parameter by
///   5 mm or 5 mrad RMS over the rows. No effect is larger, and without this bound a coefficient
///   that the poses do not show would grow without limit. A coefficient whose driver is zero stays
///   as it is.
Priors priors_of(const Robot& robot, const SessionModels& models);

/// The prior standard deviation of a parameter of the links that a fit did not identify [SI]; 0 of
/// others, which have none. `widths`: as CalibrationResult::prior_widths.
double prior_deviation(const Robot& robot, int parameter,
                       const std::map<std::string, double>& widths);

/// The information of the priors, 1 / deviation^2 on the diagonal, of `unknowns` unknowns.
Eigen::VectorXd prior_information(const std::vector<Prior>& priors, Eigen::Index unknowns);

/// Sets each width, but those of curves, to its typical value times `factor`.
void scale_widths(double factor, Priors& priors);

/// Sets the widths that are named, [SI] or factors of typical sizes.
void set_widths(const std::map<std::string, double>& widths, Priors& priors);

/// Number of unknowns that the priors, not the readings, determine: the sum of V_k / tau^2 over
/// those that share a width, V_k their posterior variances. `information`: that of the readings,
/// J^T W J. `blocks`: see SparseCholesky.
double undetermined(const Eigen::MatrixXd& information, const Priors& priors,
                    const SparseCholesky::Blocks& blocks = {});

/// Sets each width tau to the one that maximises the likelihood of the readings (type-II
/// likelihood; MacKay, "Bayesian interpolation", 1992): with d_k the changes from the expected
/// values, V_k their posterior variances and tau' the width so far,
///     gamma = sum_k (1 - V_k / tau'^2),
///     sum_k d_k^2 / tau^2 = gamma + ln(tau / typical) / log_spread^2;
/// gamma is the number of unknowns that the readings determine. `information`: as above, at x,
/// times `factor`. Returns whether no width changed by 1 % or more.
bool update_widths(const Eigen::MatrixXd& information, const Eigen::VectorXd& x, Priors& priors,
                   double factor = 1, const SparseCholesky::Blocks& blocks = {});

}  // namespace armtrue
