#pragma once

#include <map>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// See neighbours_in().
std::map<std::string, ProgramNeighbours> krl_neighbours(const Dialect& dialect,
                                                        const std::vector<ProgramText>& project,
                                                        const KnownFrames& known);

}  // namespace armtrue
