#include "programs/fanuc/fanuc_text.h"

#include <algorithm>

#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

// 1 or ,3 or R[1], behind which a comment may stand; not GP1 of PR[GP1:1].
bool ends_in_index(std::string_view text) {
  const size_t last = text.find_last_not_of(" \t");
  if (last == std::string_view::npos) return false;
  if (text[last] == ']') return true;
  if (!is_digit(text[last])) return false;
  const size_t before = text.find_last_not_of("0123456789", last);
  return before == std::string_view::npos || !is_letter(text[before]);
}

}  // namespace

std::string masked_fanuc(std::string_view program) {
  std::string text(program);
  char quote = 0;
  int depth = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      quote = 0;
      depth = 0;
    } else if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == ']') {
      depth += c == '[' ? 1 : -1;
    } else if (c == ':' && depth > 0 && ends_in_index(std::string_view(text).substr(0, i))) {
      const size_t first = text.find_first_not_of(" \t", i + 1);
      const size_t end = text.find_first_of("]\n", i + 1);
      if (end == std::string::npos || text[end] == '\n' || text[first] == '"') continue;
      std::fill(text.begin() + static_cast<long>(i) + 1, text.begin() + static_cast<long>(end),
                '_');
    }
  }
  return masked(text, '\0', "\"'");
}

}  // namespace armtrue
