#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// The index of the frame with this name, added if it is new. Its pose is that of `known`, whatever
/// the program says, else `pose`; without either it is not known. Capitals do not count.
int add_frame(std::vector<ProgramFrame>& frames, const KnownFrames& known, const std::string& name,
              const std::optional<Pose>& pose);
/// Whether `known` has a frame with this name, which stands in capitals.
bool is_given_frame(const KnownFrames& known, const std::string& name);

}  // namespace armtrue
