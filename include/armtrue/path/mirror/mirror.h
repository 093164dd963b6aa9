#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/path/low_pass.h"
#include "armtrue/path/mirror/engagement.h"
#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"
#include "armtrue/path/samples/bad_samples.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// How the trend of the deviation becomes a correction.
enum class CorrectionPoints {
  turning,  ///< straight lines between its turning points (seed paper, figure 10) and where those
            ///< lines would leave it, as far as either stands out of the noise (5 %); the lines
            ///< are fitted to the samples
  spline,   ///< the smoothing spline itself
};

/// The seed paper's: a period of 20 samples of 32 ms [Hz].
inline constexpr double kPaperCutoff = 1 / 0.64;

struct MirrorOptions {
  int order = 4;                                ///< of the Butterworth filter, each way
  std::optional<double> cutoff = kPaperCutoff;  ///< [Hz]; nothing: the one of least expected error
  CorrectionPoints points = CorrectionPoints::turning;
  std::optional<double> gain;  ///< nothing: the share of the trend that is no noise
  double max = std::numeric_limits<double>::infinity();  ///< longest correction [m]
  ClockOptions clock;
  /// What the controller ran in these passes, sampled like the programmed path, if that was not the
  /// programmed path itself but an earlier correction of it.
  std::optional<Eigen::Matrix3Xd> executed;
  bool engaged_only = false;  ///< correct only where the tool is in the material
};

/// A record against its program.
struct Pass {
  ClockFit clock;
  int samples = 0;
  int lost = 0;                ///< samples missing between the first and the last
  std::vector<BadSample> bad;  ///< of the record; left out
  double longest_gap = 0;      ///< without them [s]
};

/// Deviation (measured minus programmed) on a uniform grid of program times, mean of the passes.
struct PathDeviation {
  double period = 0;           ///< [s]
  Eigen::VectorXd time;        ///< of the program [s]
  Eigen::VectorXd arc_length;  ///< of the program [m]
  Eigen::Matrix3Xd normal;     ///< across the programmed path [m]
  Eigen::VectorXd along;       ///< in the direction of motion [m]; no correction is made of it
  Eigen::Matrix3Xd whole;      ///< both together [m]
  Eigen::Matrix3Xd force;      ///< [N]; no columns if a record has none
  Eigen::Matrix3Xd trend;      ///< of `normal`, without noise [m]
  std::vector<Eigen::Index> breaks;  ///< first samples after a corner, reversal, entry or exit:
                                     ///< there the trend may jump
  EngagementRecord engagement;       ///< from the force or, without one, from `normal`
  double noise = 0;                  ///< of one sample of `normal`, per axis [m]
  double spread = 0;                 ///< from pass to pass, per axis [m]; 0 for a single pass
  /// Of the mean of the clocks: offset halfway through `time` [s], and rate.
  Eigen::Matrix2d clock_covariance = Eigen::Matrix2d::Zero();
};

struct MirrorResult {
  std::vector<Pass> passes;
  PathDeviation deviation;
  Eigen::Matrix3Xd position;         ///< corrected, sampled like the programmed path [m]
  Eigen::Matrix3Xd correction;       ///< the same minus the programmed path
  std::vector<Eigen::Index> points;  ///< samples of the program where the correction bends
  double cutoff = 0;                 ///< [Hz]
  double gain = 1;
  int clipped = 0;     ///< samples whose correction was cut to `max`
  int unrecorded = 0;  ///< samples in motion before or after the record: nothing is corrected there
  ErrorSummary before;  ///< length of the trend while the tool moves [m]
  /// Mean distance from the programmed path in the next pass [m], if it differs from these as they
  /// do from each other: a single one says nothing of that, and it is that of the same forces and
  /// reversals.
  double expected_after = 0;
  /// What has to hold for it: one pass does not show how passes differ.
  const char* expected_if() const {
    return passes.size() > 1 ? "the next pass differs as these do from each other"
                             : "the next pass meets the same forces and reversals";
  }
  /// With `executed`: mean distance that the program itself would have shown in these passes [m].
  std::optional<double> uncorrected;
};

/// The mirror correction of the seed paper (3.2.3), made for daily use: deviations across the path
/// are averaged over the passes, smoothed piece by piece between corners, reversals and steps, and
/// taken off the programmed path. Bad samples of the records are left out first. Throws
/// std::invalid_argument as fit_clock() does, TooManyBadSamples, and if the cut-off does not go
/// with the record.
MirrorResult mirror_correct(const Path& programmed, const std::vector<Path>& measured,
                            const MirrorOptions& options);

/// A correction without any measured pass: the opposite, across the path, of what the recorded
/// forces of `programmed` make the robot deviate by (deviation_from_force()), through the
/// Butterworth filter of the options. Returns the corrected positions, sampled like the programmed
/// path [m].
Eigen::Matrix3Xd correct_from_force(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const MirrorOptions& options);

/// What force and reversals have to do with the deviation, both through the low pass: raw, a weak
/// force would not stand out of its noise. `axes` are the coordinates of the axes that may have
/// backlash, as programmed, a column for each sample of the deviation. Nothing without a force.
std::optional<ForceLaw> force_law(const PathDeviation& deviation, const Path& programmed,
                                  const Eigen::MatrixXd& axes, const LowPass& filter);

/// The deviation across the path on the one that the robot's effects predict from the recorded
/// force: k = 1 if the robot file is right; nothing without a force. Throws as joint_path() does.
std::optional<ForceLine> measured_on_predicted(const PathDeviation& deviation,
                                               const Path& programmed, const Robot& robot);

/// A recorded pass in the clock and the frame of the program.
Path registered(const Path& measured, const ClockFit& clock);

}  // namespace armtrue
