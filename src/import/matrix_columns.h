#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "import/plain_table.h"

namespace armtrue {

/// Whether a header is an element of a rotation of 3 x 3 or a transformation of 4 x 4: letters such
/// as r, m, t or rot, then row and column, from 0 or from 1: r11, M_0_3, R[2,1], rot(3,3).
bool is_matrix_element(std::string_view header);

/// The quantity of each column of the matrix in a table: r11 to r33, of its last column x, y and z,
/// of its last row "". Only columns with `is_free`. Empty if the table has no whole matrix; throws
/// InputError if it has two.
std::map<int, std::string> matrix_columns(const PlainTable& table,
                                          const std::function<bool(int)>& is_free);

}  // namespace armtrue
