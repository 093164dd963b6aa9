#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "diagnosis/changed_cause.h"

namespace armtrue {

/// An order in which the readings of a campaign may have been taken.
struct ReadingOrder {
  std::string of;  ///< line, time or pose
  std::vector<int> rows;
};

/// The orders of the times, of the lines and, if they are numbers, of the ids of the poses.
std::vector<ReadingOrder> orders_of(const Campaign& campaign);

/// The parts of a campaign that begin with these rows, in words, and how the user makes sessions of
/// them.
ChangedPart parts_from(const std::vector<int>& rows, const ReadingOrder& order,
                       const Campaign& campaign);

}  // namespace armtrue
