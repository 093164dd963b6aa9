#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Bootstrap sums, draws x columns: each draw takes as many poses as there are, with replacement,
/// and sums their values. `by_pose`: poses x columns.
Eigen::MatrixXd drawn_sums(const Eigen::MatrixXd& by_pose, int draws, std::uint64_t seed);

/// 95 % percentile interval from bootstrap draws of a value, expanded for few poses: the
/// percentiles are Phi(-+ t sqrt(n / (n - 1))), with n the number of poses and t the 0.975 quantile
/// of Student's t with n - 1 degrees of freedom (Hesterberg 2015). The interval of a mean is then
/// as wide as that of Student's t.
std::array<double, 2> percentile_interval(std::vector<double> values, int poses);

/// Cluster bootstrap by pose of the coefficients of all effects of a fit: poses are drawn with
/// replacement, each with all its readings. Returns the differences from the fit, draws x
/// coefficients [SI]. No draw is refitted: a draw is the mean of the jackknife pseudo-values of its
/// poses, each from one Newton step to the fit without that pose (see influence_of_pose). Zero in
/// directions that only one pose shows.
Eigen::MatrixXd bootstrap_coefficients(const CalibrationResult& fit, const Campaign& campaign,
                                       int draws, std::uint64_t seed);

/// 95 % interval of a value, relative to the fit. `bootstrap_draws`: its differences from the fit.
/// The draws give the asymmetry of the interval, and `deviation` its width, because the draws
/// contain neither the priors nor the directions that only one pose shows.
std::array<double, 2> interval_about(const Eigen::VectorXd& bootstrap_draws, double deviation,
                                     int poses);

/// Sets the intervals of the coefficients by interval_about().
void set_intervals(const Eigen::MatrixXd& bootstrap_draws, int poses, Robot& robot);

}  // namespace armtrue
