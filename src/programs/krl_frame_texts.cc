#include "programs/krl_frame_texts.h"

#include <algorithm>

namespace armtrue {

std::string KrlFrameTexts::text(const KrlTarget& target, const KrlValues& values,
                                KrlValues& pose) const {
  const std::string text = krl_frame_text(text_of(frame(target)), frame(target), values, pose);
  pose = inherit(inherit(pose, frame(target).values), values);
  return text;
}

std::vector<TextEdit> KrlFrameTexts::edits() const {
  std::vector<TextEdit> edits;
  for (size_t i = 0; i < uses_.size(); ++i) {
    const KrlFrame& frame = syntax_.frames[i];
    const std::string_view now = text_of(frame).substr(frame.begin, frame.end - frame.begin);
    const std::vector<Use>& uses = uses_[i];
    if (uses.empty()) continue;
    const bool agreed =
        std::ranges::all_of(uses, [&](const Use& use) { return use.text == uses.front().text; });
    if (agreed && !uses.front().target->shared) {
      if (uses.front().text != now)
        edits.push_back({frame.in_dat ? 1 : 0, frame.begin, frame.end, uses.front().text});
      continue;
    }
    for (const Use& use : uses)
      if (use.text != now) edits.push_back({0, use.target->begin, use.target->end, use.text});
  }
  return edits;
}

}  // namespace armtrue
