#pragma once

#include <string>
#include <vector>

namespace armtrue {

/// A change of one of the texts of a program: `text` in place of the bytes [begin, end).
struct TextEdit {
  int file;  ///< index of the text: of KRL 0 is the .src and 1 the .dat
  size_t begin, end;
  std::string text;
};

/// The text of one file with its edits, which must not overlap; those at one place keep their
/// order.
std::string apply_edits(const std::string& text, const std::vector<TextEdit>& edits, int file);

}  // namespace armtrue
