#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/text_edit.h"

// What a program states about the branch of a Cartesian point, after a correction.

namespace armtrue {

/// A text for each number of ProgramPoint::configuration, as the corrected joints need it; empty
/// where it stays. A number or bit that contradicts the programmed joints stays.
std::vector<std::string> configuration_texts(Dialect dialect, const ProgramPoint& point,
                                             const ProgramCommand& command);

/// The edits that make a point state the branch of the joints `q`.
std::vector<TextEdit> configuration_edits(const RobotProgram& program, const ProgramPoint& point,
                                          const JointVector& q);

}  // namespace armtrue
