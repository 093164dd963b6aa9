#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace armtrue {

/// Rows in the order of the groups that they belong to; those of group k are row[first[k]] to
/// row[first[k + 1] - 1], in ascending order.
struct GroupedRows {
  std::vector<int> first{0}, row;

  /// Adds a group of these rows.
  void add(std::span<const int> rows) {
    row.insert(row.end(), rows.begin(), rows.end());
    first.push_back(static_cast<int>(row.size()));
  }
  int groups() const { return static_cast<int>(first.size()) - 1; }
  std::span<const int> rows(int group) const {
    return std::span<const int>(row).subspan(first[group], first[group + 1] - first[group]);
  }
};

/// `number`: that of the group of each row, from 0. Numbers without rows are left out.
GroupedRows grouped_rows(const std::vector<int>& number);

}  // namespace armtrue
