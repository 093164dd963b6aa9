#pragma once

#include <string_view>
#include <vector>

#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

/// Whether positions are shifted (SFTON), by place: 0, 1 or ProgramFlow::kUncertain. `statements`:
/// the lines of //INST.
ProgramFlow::Values follow_inform_shift(std::string_view text,
                                        const std::vector<Statement>& statements);

}  // namespace armtrue
