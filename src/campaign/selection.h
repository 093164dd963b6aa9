#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// About `count` rows, evenly chosen from those of each target and anchor in each session, and of
/// all of these enough to place them.
std::vector<int> thinned_rows(const Campaign& campaign, int count);

/// All rows of about `count` poses: of every so many in each session, in the order of their ids,
/// whatever that of the rows.
std::vector<int> rows_of_some_poses(const Campaign& campaign, long count);

}  // namespace armtrue
