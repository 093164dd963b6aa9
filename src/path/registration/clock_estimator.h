#pragma once

#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// Refines offset and rate, and with `fit_frame` the frame, from a first `fit` close by; fills
/// middle and covariance too. Generalised least squares, with v the velocity, u the direction of
/// motion, f the force, t' the time from the middle of the record, along each principal direction
/// of the motion:
///     measured - programmed = -v (d_offset + d_rate t') - u (drag + [before the start] drag_0)
///                             - frame - c . f + x,
/// x the process of ornstein_uhlenbeck.h, fitted to the data of each direction. Unknowns besides
/// the clock have priors of mean 0: drag is the part of a lag that friction makes, c the
/// compliance, [before the start] is 1 until the tool first moves. The frame is that which belongs
/// to the clock; `frame_covariance` is that of fit_frame() under x. The size of the jumps of x is
/// unknown: the result is the mean over some sizes, weighted by their likelihood.
ClockFit refine_clock(const Path& programmed, const Path& measured, ClockFit fit, bool fit_frame);

}  // namespace armtrue
