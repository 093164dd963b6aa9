#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "armtrue/kinematics/pose.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// How the instrument's clock and frame lie to the program's.
struct ClockFit {
  /// t_instrument = offset + (1 + rate) * t_program [s]. A constant lag of the servos is a part of
  /// the offset: no record can tell them apart.
  double offset = 0, rate = 0;
  double middle = 0;  ///< of the record, by the clock of the program [s]
  /// Of the offset in the middle, where it is known best, and the rate. Zero if they were given.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  Pose program_from_instrument;  ///< identity unless asked for

  double program_time(double instrument_time) const {
    return (instrument_time - offset) / (1 + rate);
  }
  /// Standard deviation of the offset in the middle [s].
  double offset_deviation() const { return std::sqrt(covariance(0, 0)); }
  std::pair<double, double> offset_ci95() const {
    return {offset - 1.96 * offset_deviation(), offset + 1.96 * offset_deviation()};
  }
  /// Covariance of the offset at another time of the program, and of the rate.
  Eigen::Matrix2d covariance_at(double time) const {
    const Eigen::Matrix2d moved{{1, time - middle}, {0, 1}};
    return moved * covariance * moved.transpose();
  }
};

struct ClockOptions {
  bool fit_frame = false;  ///< refine the frame of the instrument too
  std::optional<double>
      offset;  ///< both clocks are known to be this far apart [s]: nothing is fitted
};

/// Finds the clocks of a record. The offset comes first from the correlation of the two speeds,
/// which no frame can disturb. Then offset, rate and, if asked, frame are refined by generalised
/// least squares: what the tool deviates by is a random process (Ornstein and Uhlenbeck's, its law
/// fitted to the data by axis) and the clock is what such a process cannot explain, so that a
/// deviation along the path is neither taken for time nor the other way round.
/// Throws std::invalid_argument, with the remedy, if the tool stands still in either path, if the
/// paths do not overlap in time, if they show different units, if they lie more than 10 mm apart
/// (then naming the rigid motion that would join them, if one does) or if the offset stays unknown.
ClockFit fit_clock(const Path& programmed, const Path& measured, const ClockOptions& options = {});

/// Throws std::invalid_argument, naming the unit, if the sizes of the paths or how fast they run
/// show that a column is in another unit than its name says.
void check_units(const Path& programmed, const Path& measured);

/// What the uncertainty of a clock adds to the deviations (measured minus programmed) at times of
/// the program, increasing: two independent errors of unit variance, each shared by all samples
/// [m]. `covariance` is that of the offset halfway between the first and the last of them, and the
/// rate.
std::array<Eigen::Matrix3Xd, 2> clock_errors(const Path& programmed, const Eigen::VectorXd& times,
                                             const Eigen::Matrix2d& covariance);

}  // namespace armtrue
