#include "armtrue/campaign/without_rows.h"

#include <algorithm>

namespace armtrue {

Campaign without_rows(const Campaign& campaign, const std::vector<int>& rows) {
  std::vector<int> others;
  for (int row = 0; row < campaign.rows(); ++row)
    if (!std::ranges::binary_search(rows, row)) others.push_back(row);
  return campaign.select(others);
}

}  // namespace armtrue
