#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

/// Whether positions are shifted (SFTON), by place: 0, 1 or ProgramFlow::kUncertain. `statements`:
/// the lines of //INST.
ProgramFlow::Values follow_inform_shift(std::string_view text,
                                        const std::vector<Statement>& statements);

/// Whether what follows a word that begins a line is also reached by another way than from the line
/// before: ELSE, ELSEIFEXP, DEFAULT, NEXT, ...
bool joins_inform_ways(const std::string& word);

}  // namespace armtrue
