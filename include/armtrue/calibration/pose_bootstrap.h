#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Number of times that each pose is drawn in each bootstrap draw, with replacement: draws x poses.
Eigen::MatrixXd drawn_poses(int poses, int draws, std::uint64_t seed);

/// 95 % percentile interval from bootstrap draws of a value, expanded for few poses: the
/// percentiles are Phi(-+ t sqrt(n / (n - 1))), t the 0.975 quantile of Student's law with n - 1
/// degrees of freedom, n the number of poses (Hesterberg 2015). The interval of a mean is then as
/// wide as Student's.
std::array<double, 2> percentile_interval(std::vector<double> values, int poses);

/// Cluster bootstrap by pose of the coefficients of all effects of a fit: their differences from
/// the fit when poses, each with all its readings, are drawn with replacement; draws x coefficients
/// [SI]. No draw is refitted: it is the mean of the drawn poses' jackknife pseudo-values, each from
/// the fit without one pose in one Newton step (see influence_of_pose). Zero in directions that
/// only one pose shows.
Eigen::MatrixXd bootstrap_coefficients(const CalibrationResult& fit, const Campaign& campaign,
                                       int draws, std::uint64_t seed);

/// 95 % interval, relative to the fit, of a value whose differences from the fit were drawn. The
/// draws give its asymmetry, the standard deviation its width: draws contain neither the priors nor
/// the directions that only one pose shows.
std::array<double, 2> interval_about(const Eigen::VectorXd& bootstrap_draws, double deviation,
                                     int poses);

/// Sets the intervals of the coefficients by interval_about().
void set_intervals(const Eigen::MatrixXd& bootstrap_draws, int poses, Robot& robot);

}  // namespace armtrue
