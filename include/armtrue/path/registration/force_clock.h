#pragma once

#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// Clock of a force plate, relative to that of the instrument that recorded the pass. Both run at
/// one rate: over a pass of minutes their rates differ by less than a period.
struct ForceClock {
  double offset = 0;     ///< t_plate = offset + t_instrument [s]
  double deviation = 0;  ///< standard deviation of the offset [s]; 0 if the offset was given
};

/// Finds the clock of a force record (a path without positions) by the deviation of the pass that
/// it belongs to: the tool deviates where the force is. At each offset the deviation of the tool
/// across the path d is fitted by
///     d = a + b t + C f(t + offset),    C 3 x 3, the compliance along the path,
/// and the offset by which the force explains most is the clock. Its standard deviation is the
/// larger of that by the noise of the samples and that of the jackknife over ten parts of the pass.
/// `executed` is the path that the controller ran. Throws std::invalid_argument, with the remedy:
/// as fit_clock() does for the pass; if the force record does not cover the motion of the pass; if
/// no offset or more than one explains the deviation; or if the standard deviation is 0.1 s or
/// more.
ForceClock fit_force_clock(const Path& executed, const Path& pass, const Path& force,
                           const ClockOptions& options = {});

/// The pass with the force on the tool at each of its samples: the mean of the force record over
/// one period of the pass, twice, because a plate shows each tooth and the instrument does not.
/// Samples that the force record does not cover are left out; the tool stands still there. The axes
/// of the plate are those of the program, and become those of the pass. `of_pass`: fit_clock() of
/// its good samples. Throws std::invalid_argument if the force record does not cover the motion of
/// the pass.
Path with_force(const Path& executed, const Path& pass, const ClockFit& of_pass, const Path& force,
                const ForceClock& clock);

}  // namespace armtrue
