#pragma once

#include "armtrue/effects/robot.h"

namespace armtrue {

/// Whether posture or load moves what was measured against the last link: the flange gives way,
/// which any tool follows, or the tool that carried the reflectors does. One tool does not tell.
inline bool is_of_flange_or_tool(const Effect& effect) {
  return moves_program(effect, true) && !moves_program(effect, false) &&
         !effect.driver.follows_course() && !effect.driver.involves(DriverKind::temperature);
}

}  // namespace armtrue
