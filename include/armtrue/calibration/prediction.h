#pragma once

#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// How well a calibrated robot is expected to predict the position of a reading.
struct Prediction {
  /// Standard deviation of the error of the reading, the root of the sum over its axes [m]: that of
  /// the robot by Uncertainty::root, and that of a reading.
  double deviation = 0;
  /// Length of the error that 95 % of such readings stay below [m]. With S the covariance of the
  /// error and f = (tr S)^2 / tr S^2 (Satterthwaite), |error|^2 / tr S is taken as F-distributed
  /// with f degrees of freedom and those with which S is known.
  double bound_95 = 0;
  /// Variance by Uncertainty::root over the largest at a pose of the calibration. Above 1 the pose
  /// lies outside what was measured.
  double leverage = 0;
};

/// What the uncertainty of a robot does to the mean square of the position errors of a campaign, a
/// quadratic form of normal errors: m = tr M with M = mean of G^T J^T J G over the rows.
struct MeanSquare {
  double expected = 0;  ///< m [m^2]
  double freedom = 1;   ///< of the chi-square law m chi^2 / f (Satterthwaite): m^2 / tr M^2
};
MeanSquare mean_square_by_uncertainty(const Robot& robot, const Campaign& campaign);

/// How likely it is that so many poses of a campaign that took no part lie beyond their 95 %
/// bounds, if the uncertainty of the robot holds: P(X >= outside), X ~ Binomial(poses, 0.05). What
/// the robot errs by is common to the poses, so each is predicted by the robot and by the poses
/// before it (Kalman filter; Bar-Shalom, "Estimation with Applications", 2001, 5.4): these errors
/// are independent. The robot must state its uncertainty.
double p_of_errors(const Robot& robot, const Campaign& campaign);

/// Uncertainty of a fit, for the readings that it was made of.
Uncertainty uncertainty_of(const CalibrationResult& fit, const Campaign& campaign);

/// The same, if the model lacks nothing: by the information of readings and priors, not by the
/// scatter of the poses, which few poses hardly show.
Uncertainty uncertainty_if_complete(const CalibrationResult& fit, const Campaign& campaign);

/// The uncertainty of `robot` after the geometric parameters `refitted` were fitted again to a
/// campaign. With B the whitened derivatives of its readings by these, A those by the others, C the
/// covariance of the others:
///     change of the refitted = -B^+ A (change of the others) + noise,
/// so they take up what the others do in this region. Throws std::invalid_argument if the robot
/// does not state its uncertainty.
Uncertainty after_refit(const Robot& robot, const Campaign& campaign,
                        const std::vector<int>& refitted);

/// One prediction for each row of a campaign. The robot must state its uncertainty.
std::vector<Prediction> predict(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
