#include "compensation/row_ways.h"

#include <algorithm>
#include <set>
#include <utility>

namespace armtrue {

RowWays::RowWays(const Program& program) : from_(program.ways) {
  const int rows = program.rows();
  if (from_.empty()) {
    for (int row = 0; row < rows; ++row) {
      from_.push_back(row > 0 ? std::vector{row - 1} : std::vector<int>{});
      row_of_.push_back(row);
      node_of_.push_back(row);
      order_.push_back(row);
    }
    return;
  }
  row_of_.resize(from_.size(), -1);
  node_of_ = program.node;
  for (int row = 0; row < rows; ++row) row_of_[program.node[row]] = row;
  find_order();
}

// The reverse of the order in which a search in depth leaves the nodes.
void RowWays::find_order() {
  std::vector<std::vector<int>> to(from_.size());
  for (int node = count(); node-- > 0;)
    for (const int from : from_[node]) to[from].push_back(node);
  std::vector<char> seen(from_.size(), false);
  for (int root = count(); root-- > 0;) {
    if (!from_[root].empty() || std::exchange(seen[root], true)) continue;
    std::vector<std::pair<int, size_t>> open{{root, 0}};
    while (!open.empty()) {
      auto& [node, next] = open.back();
      if (next == to[node].size()) {
        order_.push_back(node);
        open.pop_back();
      } else if (const int then = to[node][next++]; !std::exchange(seen[then], true)) {
        open.emplace_back(then, 0);
      }
    }
  }
  std::ranges::reverse(order_);
}

std::vector<int> RowWays::rows_before(int node) const {
  std::vector<int> rows, open{node};
  std::set<int> seen{node};
  while (!open.empty()) {
    const int at = open.back();
    open.pop_back();
    if (from_[at].empty()) rows.push_back(-1);
    for (const int from : from_[at])
      if (seen.insert(from).second || from == node)
        row_of_[from] >= 0 ? rows.push_back(row_of_[from]) : open.push_back(from);
  }
  return rows;
}

}  // namespace armtrue
