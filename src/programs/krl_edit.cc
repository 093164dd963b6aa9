#include "programs/krl_edit.h"

#include <algorithm>

namespace armtrue {

std::string apply_edits(const std::string& text, const std::vector<KrlEdit>& edits, bool in_dat) {
  std::vector<const KrlEdit*> order;
  for (const KrlEdit& edit : edits)
    if (edit.in_dat == in_dat) order.push_back(&edit);
  std::stable_sort(order.begin(), order.end(),
                   [](const KrlEdit* a, const KrlEdit* b) { return a->begin < b->begin; });
  std::string result;
  size_t from = 0;
  for (const KrlEdit* edit : order) {
    result.append(text, from, edit->begin - from);
    result += edit->text;
    from = edit->end;
  }
  result.append(text, from, std::string::npos);
  return result;
}

}  // namespace armtrue
