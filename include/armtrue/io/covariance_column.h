#pragma once

#include <cstddef>
#include <string>

namespace armtrue {

/// Index of an entry in the upper triangle of a 6 x 6 covariance, row by row; row <= column.
constexpr size_t place_of_covariance(int row, int column) {
  return 6 * row - row * (row - 1) / 2 + column - row;
}

/// Name of the column of an entry of the covariance, row <= column: cov_xx_mm2, cov_xrx_mm_deg,
/// cov_rxrx_deg2; with _m and _rad if `si`.
std::string covariance_column(int row, int column, bool si = false);
/// Unit of the entry in a column without `si` [SI].
double covariance_unit(int row, int column);

}  // namespace armtrue
