#pragma once

#include <string_view>
#include <vector>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// A .src or .sub of a controller, by masked().
struct KrlSourceText {
  std::string_view text;
  bool is_submit = false;  ///< .sub: it runs beside the others
};

/// Of the variables that two sources set or hand to a routine: those that calls in each source may
/// set, and those that may be set at any time.
std::vector<ProgramNeighbours::SharedVariables> krl_shared_variables(
    const std::vector<KrlSourceText>& sources);

}  // namespace armtrue
