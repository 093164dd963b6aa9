#pragma once

#include <string>

#include "statistics/ordered_blocks.h"

namespace armtrue {

/// Appends the lines of a table to `text`: `append(row, lines)` adds those of one row. Blocks of
/// rows run on all cores, and are joined in order.
template <typename Append>
void append_rows(int rows, const Append& append, std::string& text) {
  constexpr int kRowsPerText = 4096;
  for_ordered_blocks<std::string>(
      rows, kRowsPerText,
      [&](int begin, int end) {
        std::string lines;
        for (int row = begin; row < end; ++row) append(row, lines);
        return lines;
      },
      [&](const std::string& lines) { text += lines; });
}

}  // namespace armtrue
