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

/// What calls in each of the sources may set of the variables that two of them set or hand to a
/// routine, and what may be set at any time.
std::vector<ProgramNeighbours::SharedVariables> krl_shared_variables(
    const std::vector<KrlSourceText>& sources);

}  // namespace armtrue
