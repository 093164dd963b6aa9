#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// How often each of `poses` poses is drawn when as many are drawn again: draws x poses.
Eigen::MatrixXd drawn_poses(int poses, int draws, std::uint64_t seed);

/// 95 % interval from bootstrap draws of a value. Of few poses the percentiles are those of the
/// normal law at Student's quantile of poses - 1 degrees of freedom, so that the interval of a mean
/// is as wide as Student's (Hesterberg 2015).
std::array<double, 2> percentile_interval(std::vector<double> values, int poses);

/// Cluster bootstrap by pose of the coefficients of all effects of a fit: how far they depart from
/// the fit when poses, each with all its readings, are drawn again; draws x coefficients [SI].
/// Nothing is refitted: one draw is the mean of the pseudo-values of the jackknife, each the fit
/// without one pose in one Newton step, as the covariance of the fit has it (see calibrate()). Zero
/// where only one pose shows a direction.
Eigen::MatrixXd bootstrap_coefficients(const CalibrationResult& fit, const Campaign& campaign,
                                       int draws, std::uint64_t seed);

/// 95 % interval, about the fit, of a value whose departures were drawn: they give its form, the
/// standard deviation its width, since draws know nothing of priors and of what one pose shows
/// alone.
std::array<double, 2> interval_about(const Eigen::VectorXd& departures, double deviation,
                                     int poses);

/// Sets the intervals of the coefficients from their departures and standard deviations.
void set_intervals(const Eigen::MatrixXd& departures, int poses, Robot& robot);

}  // namespace armtrue
