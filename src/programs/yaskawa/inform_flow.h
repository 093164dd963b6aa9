#pragma once

#include <string_view>
#include <vector>

#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

struct InformFlow {
  ProgramFlow steps;
  ProgramFlow::Values shift;  ///< whether positions are shifted (SFTON): 0, 1 or kUncertain
};

/// How a job runs; `statements`: the lines of //INST.
InformFlow follow_inform(std::string_view text, const std::vector<Statement>& statements);

}  // namespace armtrue
