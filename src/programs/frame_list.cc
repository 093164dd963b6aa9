#include "programs/frame_list.h"

#include <algorithm>

#include "programs/text_cursor.h"

namespace armtrue {

int add_frame(std::vector<ProgramFrame>& frames, const KnownFrames& known, const std::string& name,
              const std::optional<Pose>& pose) {
  for (size_t i = 0; i < frames.size(); ++i)
    if (frames[i].name == name) return static_cast<int>(i);
  ProgramFrame frame{name, pose.value_or(Pose{}), pose.has_value()};
  for (const auto& [known_name, known_pose] : known)
    if (upper(known_name) == upper(name)) frame = {name, known_pose, true};
  frames.push_back(frame);
  return static_cast<int>(frames.size()) - 1;
}

bool is_given_frame(const KnownFrames& known, const std::string& name) {
  return std::ranges::any_of(known, [&](const auto& frame) { return upper(frame.first) == name; });
}

}  // namespace armtrue
