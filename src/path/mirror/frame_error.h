#pragma once

#include "armtrue/path/mirror/frame_error.h"
#include "armtrue/path/mirror/path_deviation.h"

namespace armtrue {

/// Of a frame that was fitted to the passes of a deviation. With C the covariance of its small
/// motion, J_i the derivative of place i by it across the path and d_i the deviation there, means
/// over the places at which the tool moves:
///     mean_square = tr(C G), G = mean of J_i' J_i,
///     form_deviation^2 = 4 h' C h + 2 tr(C G C G), h = mean of J_i' d_i,
/// the variance of the mean of |d_i + J_i e|^2 for normal e. Zero if no frame was fitted.
FrameError frame_error(const Path& programmed, const PathDeviation& deviation,
                       const ClockFit& clock);

}  // namespace armtrue
