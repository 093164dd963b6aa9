#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/observation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

struct CalibrationResult;

struct CalibrationOptions {
  bool robust = true;  ///< false: least squares whatever the residuals look like
  /// So many of the robot's effects, from the first; the others predict, but keep their
  /// coefficients.
  int fitted_effects = kAllEffects;
  int max_iterations = 1000;  ///< a direction that poses hardly show takes hundreds
  double tolerance = 1e-10;   ///< of the cost, relative: what an iteration has to gain
  /// A fit of nearly the same model to the same campaign: its spread and law of the residuals are
  /// where this one starts. nullptr: from the median.
  const CalibrationResult* near = nullptr;
};

struct CalibrationResult {
  Robot robot;  ///< with the identified values, and their standard deviations in `std`
  IdentifiableSet set;
  /// Of the unknowns: geometric parameters, coefficients, what further sessions have of their own
  /// (`session day 2 base.x`).
  std::vector<std::string> names;
  Eigen::VectorXd change;      ///< from the start [SI]
  Eigen::MatrixXd covariance;  ///< of the unknowns [SI], clustered by pose
  /// Its product with its transpose is the inverse of the information [SI]: the covariance if
  /// readings erred independently of each other, as far as `scale` says.
  Eigen::MatrixXd inverse_root;
  /// Prior knowledge of each unknown as one more equation: 1 / its standard deviation [1/SI], zero
  /// without any, and what is left of it.
  Eigen::VectorXd prior_weight, prior_residual;
  ReadingSigma scale;   ///< what readings are weighed by, per axis, in a pose that is not off
  ReadingSigma spread;  ///< of the readings about the model, per axis, in poses off as a whole too
  double degrees_of_freedom = 0;  ///< of Student's t that describes the residuals; 0 = Gaussian
  std::vector<double> weights;    ///< of each row; a row far below 1 looks like a blunder
  int rank = 0;                   ///< of all unknowns
  double condition = 0;           ///< of the Jacobian in m and rad
  std::array<double, 5> observability{};  ///< O1 ... O5
  bool converged = false;
  int iterations = 0;
  std::string termination;  ///< the solver's own words
};

/// Identifies the geometric parameters that `robot.identify` allows and the campaign can show, and
/// the coefficients of the robot's effects, from measured poses.
///
/// Maximum likelihood under Student's t with its degrees of freedom and the spreads of position and
/// orientation taken from the residuals: Levenberg-Marquardt (Ceres) on the folded residual block.
/// A base far from the measurements is first set by rigid registration of the points or anchors.
/// Several sessions are solved jointly, sparse: the robot is common, each further session adds the
/// six unknowns of its base and the zero offsets of `robot.identify_per_session`, which count in
/// covariance, rank and observability; what is found stands in `robot.sessions`.
/// Readings of a pose may err alike, so the covariance, and with it every standard deviation, is
/// from what each pose does to the fit (cluster covariance CR3 of Bell, McCaffrey 2002). Prior
/// knowledge, and what only one pose shows, which no scatter between poses can tell, count with
/// their own standard deviation and that of the readings. Intervals are Student's with one degree
/// of freedom less than there are poses.
/// Lack of convergence and of rank are reported in the result. Throws std::invalid_argument if
/// there are fewer readings than unknowns or the robot and the campaign do not fit together.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const CalibrationOptions& options = {});

/// The same with the geometric parameters given; used to refit a model after an effect is added.
CalibrationResult calibrate(const Robot& robot, const Campaign& campaign,
                            const IdentifiableSet& set, const CalibrationOptions& options = {});

/// O1 = (s_1 ... s_L)^(1/L) / sqrt(n), O2 = s_L / s_1, O3 = s_L, O4 = s_L^2 / s_1, O5 = 1 / sum
/// 1/s_i with s the singular values, largest first, of the Jacobian of n readings (Borm, Menq 1991;
/// Driels, Pathre 1990; Nahvi et al. 1994; Nahvi, Hollerbach 1996; Sun, Hollerbach 2008).
std::array<double, 5> observability(const Eigen::VectorXd& singular_values, int readings);

/// A robot carried to another set-up: only what `what` names (base, tool, single parameters) is
/// fitted, its links and effects stay as they are. Each session of the campaign has a base of its
/// own; zero offsets that `robot` knows of a session are kept.
Robot refit_set_up(const Robot& robot, const Campaign& campaign,
                   const std::vector<std::string>& what);

}  // namespace armtrue
