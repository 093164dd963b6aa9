#pragma once

#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// Paths that lie further apart [m, RMS] are in different frames, or not of one program.
inline constexpr double kMaxPathDistance = 10e-3;
/// Standard deviation of the rate of a clock, known before any record: quartz keeps time to 1e-4.
inline constexpr double kRateSigma = 2e-4;

/// Mean square distance of the two paths [m^2] with the clocks t_measured = offset + (1 + rate) *
/// t_programmed, from some thousands of samples.
double mean_square_distance(const Path& programmed, const Path& measured, double offset,
                            double rate = 0);

/// The offset of the clocks at which the speeds of the two paths correlate best [s]; no frame needs
/// to be known. If several offsets are nearly as good (a raster, a part of a pass at constant
/// speed), the one of them with the closest positions.
double first_offset(const Path& programmed, const Path& measured);

/// Offset and rate of clocks that drift apart, in a long record by more than the paths may lie
/// apart. They are fitted by least squares of the positions, first to a stretch in the middle,
/// where the offset of `fit` holds, then to stretches that double in length. If a stretch does not
/// determine them, returns the fit up to the stretch before.
ClockFit follow_drift(const Path& programmed, const Path& measured, ClockFit fit);

}  // namespace armtrue
