#pragma once

#include <string>
#include <vector>

namespace armtrue {

/// A change of the .src or the .dat: `text` in place of the bytes [begin, end).
struct KrlEdit {
  bool in_dat;
  size_t begin, end;
  std::string text;
};

/// The .dat (or the .src) with its edits, which must not overlap; those at one place keep their
/// order.
std::string apply_edits(const std::string& text, const std::vector<KrlEdit>& edits, bool in_dat);

}  // namespace armtrue
