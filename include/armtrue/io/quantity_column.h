#pragma once

namespace armtrue {

/// The column of a quantity in a table, and the factor from its unit to SI.
struct QuantityColumn {
  int column = -1;  ///< -1: not in the file
  double unit = 1;
};

}  // namespace armtrue
