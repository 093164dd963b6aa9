#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace armtrue {

/// The text without the blanks at its ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// A text in place of the bytes [begin, end) of another one.
struct Replacement {
  size_t begin, end;
  std::string text;
};
/// The text with all replacements, none of which may overlap; those at one place keep their order.
std::string replaced(std::string_view text, std::vector<Replacement> replacements);

}  // namespace armtrue
