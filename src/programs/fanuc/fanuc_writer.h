#pragma once

#include <memory>
#include <string>

#include "programs/insertion.h"

namespace armtrue {

/// Points are positions of /POS; lines and LINE_COUNT are numbered anew.
std::unique_ptr<MoveWriter> fanuc_writer(const RobotProgram& program);

/// Throws InputError if a controller would not load the program with so many moves more.
void refuse_long_fanuc_program(const RobotProgram& program, size_t inserted);

/// Adds a comment as the last instruction of /MN, with its number.
void add_fanuc_remark(const std::string& remark, std::string& text);

}  // namespace armtrue
