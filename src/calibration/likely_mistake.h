#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The mistake that explains a pose that is off, in words: each mistake is corrected in turn, and
/// the best counts if all readings then fit within `tolerance` (or 2 % of `off`) and a third of
/// `off` [m]. Mistakes: joint angles of another pose, exchanged or copied; ids of targets
/// exchanged; another session; a joint's sign; two joints exchanged; degrees for radians; a wrong
/// unit or a wrong sign of a coordinate, two coordinates exchanged. If none does, one joint value
/// that is wrong by any amount, with which the readings must fit to a thirtieth of `off`.
/// `readings`: of each pose that is off, one row for each of its channels; `which`: index of the
/// pose.
std::optional<std::string> likely_mistake(const Robot& fitted, const Campaign& campaign,
                                          const std::vector<std::vector<int>>& readings,
                                          size_t which, double off, double tolerance);

}  // namespace armtrue
