#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// The curve that the correction follows.
enum class CorrectionPoints {
  /// A polygon (seed paper, figure 10). Its vertices are the turning points of the smoothed
  /// deviation, and points where the lines between these would leave it, as far as they are
  /// significant against the noise (5 %). The polygon is then fitted to the samples.
  turning,
  /// The smoothing spline of the deviation.
  spline,
};

/// The cut-off of the seed paper [Hz]: a period of 20 samples of 32 ms.
inline constexpr double kPaperCutoff = 1 / 0.64;

struct MirrorOptions {
  int order = 4;  ///< of the Butterworth filter, each way
  /// Cut-off [Hz]; empty: the one with the smallest expected error is chosen.
  std::optional<double> cutoff = kPaperCutoff;
  CorrectionPoints points = CorrectionPoints::turning;
  /// Share of the trend that is corrected; empty: 1 - (its mean square error / its mean square).
  std::optional<double> gain;
  double max = std::numeric_limits<double>::infinity();  ///< longest correction [m]
  ClockOptions clock;
  /// The path that the controller ran in these passes, sampled like the programmed path, if that
  /// was an earlier correction of it [m].
  std::optional<Eigen::Matrix3Xd> executed;
  bool engaged_only = false;  ///< correct only where the tool is in the material
};

}  // namespace armtrue
