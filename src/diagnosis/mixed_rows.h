#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Names a mistake that only some of the rows have: lengths in another unit, joint angles in
/// radians, orientations in radians, exchanged columns, an axis with the wrong sign. Nothing if
/// there is none, or for distances.
///
/// Base and tool are fitted to all rows. If the median error stays above `good`, they are fitted
/// many times to six random poses, and the fit with the most rows within `good` is taken. A mistake
/// is named if its correction brings three poses with errors above `good` below `good`, and to a
/// tenth of their errors; `good_turn` [rad] is the same for their orientations.
std::optional<std::string> find_mixed_rows(const Robot& robot, const Campaign& campaign,
                                           double good, double good_turn);

}  // namespace armtrue
