#include "armtrue/text/text_parts.h"

#include <algorithm>

namespace armtrue {

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto is_blank = [&](char c) { return std::ranges::find(blanks, c) != blanks.end(); };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string replaced(std::string_view text, std::vector<Replacement> replacements) {
  std::ranges::stable_sort(replacements, {}, &Replacement::begin);
  std::string result;
  size_t copied = 0;
  for (const Replacement& replacement : replacements) {
    result.append(text, copied, replacement.begin - copied);
    result += replacement.text;
    copied = replacement.end;
  }
  return result.append(text, copied);
}

}  // namespace armtrue
