#include "armtrue/campaign/grouped_rows.h"

#include <algorithm>
#include <numeric>

namespace armtrue {

GroupedRows grouped_rows(const std::vector<int>& number) {
  const int numbers = number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end());
  GroupedRows rows{std::vector<int>(numbers + 1, 0), std::vector<int>(number.size())};
  for (int k : number) ++rows.first[k];
  std::partial_sum(rows.first.begin(), rows.first.end(), rows.first.begin());
  // From their ends, where `first` points, to their beginnings, where it points then.
  for (size_t row = number.size(); row-- > 0;)
    rows.row[--rows.first[number[row]]] = static_cast<int>(row);
  rows.first.erase(std::unique(rows.first.begin(), rows.first.end()), rows.first.end());
  return rows;
}

}  // namespace armtrue
