#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Names a mistake that only a part of the rows has: lengths in another unit, joint angles in
/// radians, orientations in radians, exchanged columns, an axis with the wrong sign. Nothing if
/// there is none, or for distances.
///
/// Base and tool are fitted to all rows or, where the median of their misses stays above `good`,
/// to six poses drawn at random, many times; the fit that most rows lie within `good` of is taken.
/// A mistake is named if without it three poses that miss by more than `good` would miss by less,
/// and by a tenth of what they do; `good_turn` [rad] is the same for their orientations.
std::optional<std::string> find_mixed_rows(const Robot& robot, const Campaign& campaign,
                                           double good, double good_turn);

}  // namespace armtrue
