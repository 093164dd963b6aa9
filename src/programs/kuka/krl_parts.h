#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "armtrue/programs/dialect.h"
#include "programs/routine_copies.h"

// What KrlDialect is made of.

namespace armtrue {

/// See Dialect::parse().
void parse_krl_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

/// The subprograms of a KRL program, and with which $BASE, $TOOL and $IPO_MODE each call runs.
std::vector<Routine> krl_routines(const RobotProgram& program, const KnownFrames& known);

/// See FolderTexts: $config.dat and PUBLIC data lists, and to what names sources give values.
std::unique_ptr<FolderTexts> krl_folder(const std::vector<const ProgramText*>& texts);

/// See neighbours_in().
std::map<std::string, ProgramNeighbours> krl_neighbours(const Dialect& dialect,
                                                        const std::vector<ProgramText>& project,
                                                        const KnownFrames& known);

}  // namespace armtrue
