#pragma once

#include <string>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// That points of one pose, session and target lie apart as an arm that stands still does not put
/// them, as a sentence with the remedy; empty if they agree. A reading is apart if it lies 5 mm and
/// ten times the median of all such distances from the median of its pose, coordinate by
/// coordinate. Said where that is so in three poses and a tenth of those with several points: fewer
/// are blunders.
std::string scattered_poses(const Campaign& campaign);

}  // namespace armtrue
