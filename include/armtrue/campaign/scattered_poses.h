#pragma once

#include <string>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// A sentence, with the remedy, if points of one pose, session and target scatter more than any arm
/// repeats; else empty. A point is apart if its distance from the median of its pose (by
/// coordinate) exceeds 5 mm and ten times the median of all such distances. The sentence needs such
/// points in three poses and in a tenth of those with several points: fewer are blunders.
std::string scattered_poses(const Campaign& campaign);

}  // namespace armtrue
