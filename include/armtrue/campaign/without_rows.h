#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// The campaign without some rows, which are in ascending order.
Campaign without_rows(const Campaign& campaign, const std::vector<int>& rows);

}  // namespace armtrue
