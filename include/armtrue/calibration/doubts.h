#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/left_out.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Number of these lines of a file, and the first twelve of them; empty if none.
std::string lines_in_words(const std::vector<int>& lines);

/// Where the readings that a fit leaves out stand together, as a sentence; empty if they lie as
/// blunders do, at random. A fault that lasts for a while puts them close together in time, a bad
/// reflector on one target (p < 0.001). `lines`: of the file, those of gross poses included;
/// ascending.
std::string left_out_together(const Campaign& campaign, const std::vector<int>& lines);

/// Why the readings contradict the noise that the rows or, without such a column, the robot file
/// state, as a sentence; empty if they do not (p < 0.001). Replicates scatter more than the stated
/// noise: the arm returns worse than the file says. Single readings scatter much less about the
/// model: the stated noise is too large, and hides every effect.
std::string contradiction_of_noise(const Robot& robot, const Campaign& campaign,
                                   const CalibrationResult& fit, const NoiseFloor& noise);

/// How many times the noise of its readings a fit leaves, in position or in orientation, whichever
/// is more; 1 if that is at most five times, or the noise is unknown. Above, 4 % or less of the
/// squared residual is noise: the rest is the model's, which all poses have in common, and standard
/// deviations that take it for independent from pose to pose promise too much.
double times_of_noise(const FitQuality& quality);

/// That a fit leaves more than five times the noise, as a sentence, see times_of_noise(); or empty.
std::string far_above_noise(const FitQuality& quality);

/// Multiplies the standard deviations of parameters and coefficients by a factor, intervals
/// likewise. CalibrationResult::covariance stays: predictions at poses like those of the fit have
/// the same rest as its residual, which is counted there by itself.
void widen_deviations(double factor, CalibrationResult& fit);

/// That the bounds which a robot states do not hold for these readings, as a sentence; else empty:
/// less than 80 % of the readings lie within their 95 % bounds, and the number of poses outside is
/// no chance (p_of_errors() < 0.001). The noise of these readings counts if it is larger than that
/// of the calibration. The arms measured so far keep a rest that is not normal, and
/// up to 10 % outside. `predictions`: of each row.
std::string broken_bounds(const Robot& robot, const Campaign& campaign,
                          const Evaluation& evaluation, const std::vector<Prediction>& predictions);

/// That a fit did not converge, with the remedy; empty if it did.
std::string not_converged(const CalibrationResult& fit);

/// Which parameters these poses do not show that other poses would, and what small angles of the
/// arm alone show; empty if there is none.
std::string lost_in_words(const Robot& robot, const Campaign& campaign,
                          const CalibrationResult& fit);

/// Which parameters stay near their nominal value for lack of readings, and how many more poses
/// would determine them; empty if there is none.
std::string near_nominal_in_words(const CalibrationResult& fit, const Campaign& campaign);

/// That the readings lie more than the radius of the zone outside it, so that the fit extrapolates
/// there; else empty.
std::string far_from_readings(const WeightedZone& zone);

/// That `identify` leaves out parameters which the readings show, for a search of effects.
std::string left_out_in_words(const Robot& robot, const LeftOut& left_out);

/// Of each pose that is left out because all its readings share a large error, a sentence.
std::vector<std::string> off_as_wholes(const std::vector<GrossPose>& gross);

/// What touches do not show: the place of R_A, and the scale, unless an artefact or an encoder of
/// lengths shows it. Empty where not all readings are touches. `robot`: the one for which the set
/// was chosen.
std::vector<std::string> not_shown_by_touches(const Robot& robot, const Campaign& campaign,
                                              const IdentifiableSet& set);

/// That the parameters `refit`, fitted to few readings, take up more than a fifth of their errors,
/// which are then those of no other pose; else empty. `given`: the robot before the fit.
std::string hidden_by_refit(const std::vector<std::string>& refit, const Robot& given,
                            const Campaign& campaign);

}  // namespace armtrue
