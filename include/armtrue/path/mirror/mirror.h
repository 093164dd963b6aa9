#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/frame_error.h"
#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/mirror/path_deviation.h"
#include "armtrue/path/path.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// The result of mirror_correct().
struct MirrorResult {
  std::vector<Pass> passes;
  PathDeviation deviation;
  Eigen::Matrix3Xd position;         ///< corrected, sampled like the programmed path [m]
  Eigen::Matrix3Xd correction;       ///< `position` minus the programmed path [m]
  std::vector<Eigen::Index> points;  ///< samples of the program where the correction bends
  double cutoff = 0;                 ///< [Hz]
  double gain = 1;
  int clipped = 0;  ///< samples whose correction was limited to `max`
  /// Samples in motion before or after the record; they keep the path that was run.
  int unrecorded = 0;
  ErrorSummary before;  ///< length of the trend while the tool moves [m]
  /// Expected mean distance from the programmed path in the next pass [m], under the condition that
  /// expected_if() names. With s the mean distance that stays uncorrected (because of the gain,
  /// `max` or the engagement), B the mean square of the deviation of each of n passes from their
  /// common one (0 for a single pass), F the mean square of `frame`, and M the mean square error of
  /// the trend, B / n included,
  ///     sqrt(max(0, s^2 - (pi / 4) (1 - gain)^2 B / n) + (pi / 4) (gain^2 M + B + F)).
  double expected_after = 0;
  /// The condition of expected_after; a single pass does not show how passes differ.
  const char* expected_if() const {
    return passes.size() > 1 ? "the next pass differs as these do from each other"
                             : "the next pass meets the same forces and reversals";
  }
  FrameError frame;  ///< zero unless the frame was fitted
  /// Only with `executed`: mean distance of these passes without the earlier correction [m].
  std::optional<double> uncorrected;
};

/// The mirror correction of the seed paper (3.2.3), in this order: bad samples are left out; the
/// records are registered; the deviations across the path are averaged over the passes, cut into
/// pieces where they jump, and smoothed piece by piece to a trend. With e the executed and p the
/// programmed path, N the part across the path,
///     corrected = p + N (e - p - gain * trend).
/// At corners the corrected sides are extended until they meet. Outside the records the executed
/// path stays. Where a record begins or ends in motion, and with `engaged_only` where the tool
/// enters or leaves the material, the new correction grows linearly in time from 0 to its full size
/// within 1 / cut-off, so that the path has no step. Throws std::invalid_argument as fit_clock()
/// does and if the cut-off does not suit the record, and TooManyBadSamples.
MirrorResult mirror_correct(const Path& programmed, const std::vector<Path>& records,
                            const MirrorOptions& options);

/// A correction without a measured pass, from the deviation by the forces of `programmed`
/// (deviation_from_force()): corrected = p - gain * N filter(deviation), with the Butterworth
/// filter of the options and gain 1 if they have none. Returns the corrected positions, sampled
/// like the programmed path [m].
Eigen::Matrix3Xd correct_from_force(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const MirrorOptions& options);

}  // namespace armtrue
