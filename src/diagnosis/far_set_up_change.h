#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Names the places in a campaign of one session after which the readings lie in another frame, or
/// the reflector is elsewhere on the tool, by more than any arm errs (kImplausibleMiss). A fit to
/// all readings is no start: if no part has most of the readings, even a robust fit lies between
/// the parts.
///
/// In the order of the times, of the lines and of the numbers of the poses: base and tool are
/// fitted to the first readings, then to all that follow and fit these, until no more do; the next
/// part begins there. Wrong units, signs and columns give no parts, because no readings fit. The
/// first part may be too short, so the same is tried from the end. Nothing if six readings or more
/// do not lie far from one base and tool, if two to four parts do not hold nearly all readings, or
/// if neither the base nor the tool alone makes the difference.
std::optional<std::string> find_far_set_up_change(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
