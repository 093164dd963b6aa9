#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armtrue/programs/dialect.h"
#include "programs/insertion.h"

// What FanucDialect is made of.

namespace armtrue {

/// See Dialect::parse().
void parse_fanuc_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

/// See FolderTexts: listings of a controller, and the position registers to which programs give
/// values.
std::unique_ptr<FolderTexts> fanuc_folder(const std::vector<const ProgramText*>& texts);

/// Points are positions of /POS; lines and LINE_COUNT are numbered anew.
std::unique_ptr<MoveWriter> fanuc_writer(const RobotProgram& program);

/// Throws InputError if a controller would not load the program with so many moves more.
void refuse_long_fanuc_program(const RobotProgram& program, size_t inserted);

/// Adds a comment as the last instruction of /MN, with its number.
void add_fanuc_remark(const std::string& remark, std::string& text);

}  // namespace armtrue
