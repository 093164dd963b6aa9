#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armtrue/programs/dialect.h"
#include "programs/insertion.h"

// What InformDialect is made of.

namespace armtrue {

/// See Dialect::parse().
void parse_inform_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

/// See FolderTexts: the variables that jobs set, and the frames and tools that called jobs set.
std::unique_ptr<FolderTexts> inform_folder(const std::vector<const ProgramText*>& texts);

/// Points are positions of //POS: new ones stand behind the last C, and count in NPOS.
std::unique_ptr<MoveWriter> inform_writer(const RobotProgram& program);

/// Throws InputError if a controller would not load the job with so many moves more.
void refuse_long_inform_job(const RobotProgram& program, size_t inserted);

/// Adds a comment behind NOP, or where the instructions begin.
void add_inform_comment(const std::string& comment, std::string& text);

}  // namespace armtrue
