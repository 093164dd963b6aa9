#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// How well a calibrated robot is expected to predict the position of a reading.
struct Prediction {
  /// Standard deviation of the error of the reading, root of the sum of squares over its axes [m].
  /// Contains the uncertainty of the robot (Uncertainty::root) and that of a reading.
  double deviation = 0;
  /// 95 % bound of the length of the error [m]. S is the covariance of the error, with the variance
  /// of the reading times the square of Uncertainty::tail. |error|^2 / tr S is taken as
  /// F-distributed with f = (tr S)^2 / tr S^2 (Satterthwaite) and the degrees of freedom of the
  /// estimate of S.
  double bound_95 = 0;
  /// Variance by Uncertainty::root, divided by the largest one at a pose of the calibration: of
  /// points by that of a point, if the calibration read lengths. Above 1 the pose lies outside what
  /// was measured.
  double leverage = 0;
};

/// Uncertainty::root of further sessions, by name, with their own parameters in the place of those
/// of the first. A session without one counts as the first.
using RootsOfSessions = std::map<std::string, Eigen::MatrixXd>;

/// Contribution of the uncertainty of a robot to the mean square of the position errors of a
/// campaign. It is a quadratic form of normal errors: m = tr M with M = mean of G^T J^T J G over
/// the rows.
struct MeanSquare {
  double expected = 0;  ///< m [m^2]
  double freedom = 1;   ///< of the chi-square law m chi^2 / f (Satterthwaite): m^2 / tr M^2
};
MeanSquare mean_square_by_uncertainty(const Robot& robot, const Campaign& campaign,
                                      const RootsOfSessions& roots = {});

/// p-value of the number of held-out poses beyond their 95 % bounds under the stated uncertainty of
/// the robot: P(X >= outside), X ~ Binomial(poses, 0.05). The errors of the robot are common to the
/// poses. So each pose is predicted by the robot and by the poses before it (Kalman filter;
/// Bar-Shalom, "Estimation with Applications", 2001, 5.4): these prediction errors are independent.
/// The robot must state its uncertainty. Where rows state standard deviations, each counts by its
/// own over `usual`, the usual_sigma() of the calibration [m]; 0: over that of the campaign.
double p_of_errors(const Robot& robot, const Campaign& campaign, double usual = 0,
                   const RootsOfSessions& roots = {});

/// RMS of the standard deviations that rows state [m], 0 if they state none: Uncertainty::reading
/// is that of a row which states it.
double usual_sigma(const Campaign& campaign);

/// Uncertainty of a fit to a campaign. `evaluation`: of its robot on the campaign.
Uncertainty uncertainty_of(const CalibrationResult& fit, const Campaign& campaign,
                           const Evaluation& evaluation);
Uncertainty uncertainty_of(const CalibrationResult& fit, const Campaign& campaign);

/// The same for a model that lacks nothing: from the information of readings and priors, not from
/// the scatter of the poses, which few poses estimate poorly. That of a session of few points is
/// its own; of more than 800 unknowns all count as the first.
struct IfComplete {
  Uncertainty uncertainty;
  RootsOfSessions roots;
};
IfComplete uncertainty_if_complete(const CalibrationResult& fit, const Campaign& campaign);

/// The uncertainty of `robot` after the geometric parameters `refitted` were fitted again to a
/// campaign. With B the whitened derivatives of its readings by these, A those by the others, C the
/// covariance of the others:
///     change of the refitted = -B^+ A (change of the others) + noise,
/// so in this region they compensate the errors of the others. Throws std::invalid_argument if the
/// robot does not state its uncertainty.
Uncertainty after_refit(const Robot& robot, const Campaign& campaign,
                        const std::vector<int>& refitted);

/// One prediction for each row of a campaign. The robot must state its uncertainty. Where rows
/// state standard deviations, each counts by its own over the usual_sigma() of the campaign.
std::vector<Prediction> predict(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
