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

/// A sentence if the readings that a fit leaves out stand together in time, as with a fault that
/// lasts for a while, or on one target, contact or anchor, as with a bad reflector or a socket that
/// was moved (p < 0.001); empty if they lie at random, as blunders do. `lines`: of the file, those
/// of gross poses included; ascending.
std::string left_out_together(const Campaign& campaign, const std::vector<int>& lines);

/// Why the readings contradict the noise that the rows or, without such a column, the robot file
/// state, as a sentence; empty if they do not. Replicates scatter more than the file states (1.25
/// times, p < 0.001): the arm returns worse. Single readings scatter less than a third of it about
/// the model (p < 0.001): the stated noise hides every effect. They scatter 100 times as much,
/// orientations also a hundredth: another unit.
std::string contradiction_of_noise(const Robot& robot, const Campaign& campaign,
                                   const CalibrationResult& fit, const NoiseFloor& noise);

/// Residual of a fit divided by the noise of its readings, of position or orientation, whichever is
/// more; 1 if that is at most 5, or the noise is unknown. Above 5, at most 4 % of the squared
/// residual is noise. The rest is an error of the model that all poses share, so standard
/// deviations that take poses as independent are too small.
double times_of_noise(const FitQuality& quality);

/// A sentence if times_of_noise() is above 1; else empty.
std::string far_above_noise(const FitQuality& quality);

/// Multiplies the standard deviations of parameters and coefficients by a factor, intervals
/// likewise. CalibrationResult::covariance stays: predictions at poses like those of the fit count
/// the residual separately.
void widen_deviations(double factor, CalibrationResult& fit);

/// A sentence if the bounds of a robot do not hold for these readings; else empty. They do not if
/// less than 80 % of the readings lie within their 95 % bounds, and p_of_errors() < 0.001. The
/// noise of these readings counts if it is larger than that of the calibration. On the arms
/// measured so far up to 10 % lie outside, because what the models lack is not normal.
/// `predictions`: of each row.
std::string broken_bounds(const Robot& robot, const Campaign& campaign,
                          const Evaluation& evaluation, const std::vector<Prediction>& predictions);

/// A sentence if the parameters of a robot are much less uncertain than its file states: its mean
/// square error at these readings, noise included, is below a thousandth (30^2) of the mean square
/// by Uncertainty::root, and p < 0.001 (see MeanSquare). Else empty.
std::string contradiction_of_uncertainty(const Robot& robot, const Campaign& campaign,
                                         const Evaluation& evaluation);

/// A sentence with the remedy if a fit did not converge; else empty.
std::string not_converged(const CalibrationResult& fit);

/// Which parameters only other poses would show, see lost_to_poses(), and which only small angles
/// of the arm show; empty if there is none.
std::string lost_in_words(const Robot& robot, const Campaign& campaign,
                          const CalibrationResult& fit);

/// Which parameters stay near their nominal value for lack of readings, and how many more poses
/// would determine them; empty if there is none.
std::string near_nominal_in_words(const CalibrationResult& fit, const Campaign& campaign);

/// A sentence if the nearest reading is farther outside the zone than its radius, so that the fit
/// extrapolates there; else empty.
std::string far_from_readings(const WeightedZone& zone);

/// The sentence of a search of effects on parameters that `identify` leaves out and the readings
/// show.
std::string left_out_in_words(const Robot& robot, const LeftOut& left_out);

/// A sentence for each pose that is left out because all its readings share a large error, and one
/// for all poses that one cause explains.
std::vector<std::string> off_as_wholes(const std::vector<GrossPose>& gross);

/// The same for poses that no fit uses, such as those held out: their errors count.
std::vector<std::string> off_and_counted(const std::vector<GrossPose>& gross);

/// Sentences on the place of R_A and the scale, which touches do not show, the scale unless an
/// artefact or an encoder of lengths does. Empty if not all readings are touches. `robot`: the one
/// for which the set was chosen.
std::vector<std::string> not_shown_by_touches(const Robot& robot, const Campaign& campaign,
                                              const IdentifiableSet& set);

/// What a fit hides of the errors of the readings that it was fitted to.
struct HiddenError {
  double unknowns = 0;  ///< that are fitted; 0: nothing is
  double freedom = 0;   ///< numbers that are read less unknowns; 0: the fit hides all of the error
  std::string words;    ///< a sentence on the share of the RMS error; empty if it is below a fifth
};

/// The errors that the parameters `refit` absorb, so that other poses have larger errors. `given`:
/// the robot before the fit.
HiddenError hidden_by_refit(const std::vector<std::string>& refit, const Robot& given,
                            const Campaign& campaign);

/// The RMS error with what the fit hides, over the RMS that it left, which is not exceeded with a
/// `probability`. If all numbers err alike, u unknowns take up squares that are to the squares of
/// the f numbers left as u / f F, with F of Fisher's law:
///     sqrt(1 + u / f F(u, f)).
/// 1 if nothing is fitted, infinite if no number is left.
double most_with_hidden(const HiddenError& hidden, double probability);

}  // namespace armtrue
