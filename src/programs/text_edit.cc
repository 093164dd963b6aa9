#include "programs/text_edit.h"

#include <algorithm>

namespace armtrue {

std::string apply_edits(const std::string& text, const std::vector<TextEdit>& edits, int file) {
  std::vector<const TextEdit*> order;
  for (const TextEdit& edit : edits)
    if (edit.file == file) order.push_back(&edit);
  std::stable_sort(order.begin(), order.end(),
                   [](const TextEdit* a, const TextEdit* b) { return a->begin < b->begin; });
  std::string result;
  size_t from = 0;
  for (const TextEdit* edit : order) {
    result.append(text, from, edit->begin - from);
    result += edit->text;
    from = edit->end;
  }
  result.append(text, from, std::string::npos);
  return result;
}

}  // namespace armtrue
