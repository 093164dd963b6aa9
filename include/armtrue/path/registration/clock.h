#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/pose.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// With a larger standard deviation the offset of a clock counts as unknown [s].
inline constexpr double kMaxOffsetSigma = 0.1;

/// Clock and frame of an instrument, relative to those of the program.
struct ClockFit {
  /// t_instrument = offset + (1 + rate) * t_program [s]. The offset includes a constant lag of the
  /// servos: no record can tell them apart.
  double offset = 0, rate = 0;
  double middle = 0;  ///< middle of the record, by the clock of the program [s]
  /// Covariance of the offset at `middle`, where it is known best, and the rate. Zero if the offset
  /// was given.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  Pose program_from_instrument;  ///< identity unless the frame was fitted
  /// Covariance of a small motion of the fitted frame: the displacement of `frame_pivot` [m] and
  /// the rotation about it [rad], along the axes of the program. Zero if the frame was not fitted.
  Eigen::Matrix<double, 6, 6> frame_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d frame_pivot = Eigen::Vector3d::Zero();

  /// Derivative of the place of a point by that motion: [1, -[point - pivot]x].
  Eigen::Matrix<double, 3, 6> by_frame(const Eigen::Vector3d& point) const;
  double program_time(double instrument_time) const {
    return (instrument_time - offset) / (1 + rate);
  }
  /// Standard deviation of the offset at `middle` [s].
  double offset_deviation() const { return std::sqrt(covariance(0, 0)); }
  std::pair<double, double> offset_ci95() const {
    return {offset - 1.96 * offset_deviation(), offset + 1.96 * offset_deviation()};
  }
  /// Covariance of the offset at another time of the program and of the rate: F C F' with
  /// F = [1, time - middle; 0, 1].
  Eigen::Matrix2d covariance_at(double time) const {
    const Eigen::Matrix2d moved{{1, time - middle}, {0, 1}};
    return moved * covariance * moved.transpose();
  }
};

struct ClockOptions {
  bool fit_frame = false;  ///< fit the frame of the instrument too
  /// Known offset of the clocks [s]. If present, no clock is fitted.
  std::optional<double> offset;
};

/// Finds the clock of a record. The first offset is the one at which the speeds of both paths
/// correlate best; it depends on no frame. Generalised least squares then refine offset and rate,
/// with the frame as an unknown if it is asked for. They model the deviation of the tool as a
/// random process (Ornstein-Uhlenbeck), fitted to the data of each axis. So a deviation along the
/// path is not taken for an error of the clock, nor an error of the clock for a deviation. The
/// frame is that of least squares of the deviation, mainly across the path; the process is in its
/// covariance. Throws std::invalid_argument, with the remedy: if the tool stands still in either
/// path; if the paths do not overlap in time; if their units differ (check_units()); if they lie
/// more than 10 mm apart (the message names the rigid motion that joins them, if there is one); or
/// if the standard deviation of the offset is 0.1 s or more.
ClockFit fit_clock(const Path& programmed, const Path& measured, const ClockOptions& options = {});

/// A record that cannot be registered; the message says why, as that of fit_clock().
struct UnusablePass : std::invalid_argument {
  UnusablePass(size_t which, const std::string& why) : std::invalid_argument(why), pass(which) {}
  size_t pass;  ///< index of the record
};

/// What is wrong with the columns of a record that lies on the program, where it stands, with two
/// of them exchanged or one of the other sign: "z of the other sign"; empty if none of these makes
/// it so.
std::string mistaken_columns(const Path& programmed, const Path& measured);

/// The clocks of passes that an instrument recorded in one set-up, each as by fit_clock(). A fitted
/// frame is one for all of them, see share_frame(). Throws UnusablePass.
std::vector<ClockFit> fit_clocks(const Path& programmed, const std::vector<Path>& passes,
                                 const ClockOptions& options = {});

/// Gives passes with fitted frames one frame, so that differences between passes stay deviations of
/// the tool: that of least squares of all of them. The deviation that all passes have in common
/// misleads all alike, so the covariance is the mean of theirs. The clocks are fitted again in this
/// frame. Throws std::invalid_argument if a pass lies more than 2
/// mm (rms) from where the common frame has it: then the instrument was moved.
void share_frame(const Path& programmed, const std::vector<Path>& passes,
                 std::vector<ClockFit>& clocks);

/// The record, its forces too, in the clock and the frame of the program.
Path registered(const Path& measured, const ClockFit& clock);

/// The errors of the deviations (measured minus programmed) by an uncertain clock, at increasing
/// times of the program. Error k at time t is v(t) (R_0k + R_1k (t - t_mid)) [m], times a number of
/// unit variance that all samples share. t_mid is halfway between the first and the last time; R R
/// = `covariance`, that of the offset at t_mid and the rate.
std::array<Eigen::Matrix3Xd, 2> clock_errors(const Path& programmed, const Eigen::VectorXd& times,
                                             const Eigen::Matrix2d& covariance);

}  // namespace armtrue
