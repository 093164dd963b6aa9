#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Names the places in a campaign of one session after which the readings lie in another frame, or
/// the reflector is elsewhere on the tool, by more than any arm errs (kImplausibleMiss). No fit to
/// all is a start there: where no part has most of the readings, even a robust one stands between.
///
/// In the order of the times, of the lines and of the numbers of the poses: base and tool are
/// fitted to the first readings, then to all that follow and fit these, until no more do; the next
/// part begins there. So wrong units, signs and columns have no parts: these fit no readings. The
/// first part may be too short, so the same is tried from the end. Nothing if six readings or more
/// do not lie far from one base and tool, if two to four parts do not hold nearly all readings, or
/// if neither the base nor the tool alone makes the difference.
std::optional<std::string> find_far_set_up_change(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
