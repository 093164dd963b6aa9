#pragma once

#include <vector>

#include "armtrue/compensation/compensation.h"

namespace armtrue {

/// The ways between the rows of a program: a graph whose nodes are rows, and places where ways meet
/// or where the program begins.
class RowWays {
 public:
  explicit RowWays(const Program& program);

  /// All nodes that matter: each behind one from which the arm comes to it, if there is one.
  const std::vector<int>& order() const { return order_; }
  /// -1: none.
  int row_of(int node) const { return row_of_[node]; }
  int count() const { return static_cast<int>(from_.size()); }
  /// Nodes from which the arm comes to a node; none: the program begins there.
  const std::vector<int>& from(int node) const { return from_[node]; }
  int node_of(int row) const { return node_of_[row]; }
  /// The rows from which the arm may come to a node, with none between; -1: the program begins.
  std::vector<int> rows_before(int node) const;

 private:
  void find_order();

  std::vector<std::vector<int>> from_;
  std::vector<int> row_of_, node_of_, order_;
};

}  // namespace armtrue
