#pragma once

#include <memory>
#include <string>

#include "programs/insertion.h"

namespace armtrue {

/// Points are positions of //POS: new ones stand behind the last C, and count in NPOS.
std::unique_ptr<MoveWriter> inform_writer(const RobotProgram& program);

/// Throws InputError if a controller would not load the job with so many moves more.
void refuse_long_inform_job(const RobotProgram& program, size_t inserted);

/// Adds a comment behind NOP, or where the instructions begin.
void add_inform_comment(const std::string& comment, std::string& text);

}  // namespace armtrue
