#pragma once

#include <string>
#include <string_view>

namespace armtrue {

/// Least number of characters to insert, remove or replace that turn one text into the other
/// (Levenshtein); of bytes, not of UTF-8.
int edit_distance(std::string_view a, std::string_view b);

/// The text in lower or upper case; only the letters of ASCII change.
std::string lower_case(std::string_view text);
std::string upper_case(std::string_view text);

}  // namespace armtrue
