#include "programs/text_edit.h"

#include "armtrue/text/text_parts.h"

namespace armtrue {

std::string apply_edits(const std::string& text, const std::vector<TextEdit>& edits, int file) {
  std::vector<Replacement> own;
  for (const TextEdit& edit : edits)
    if (edit.file == file) own.push_back({edit.begin, edit.end, edit.text});
  return replaced(text, std::move(own));
}

}  // namespace armtrue
