#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"

// A routine that is called with several tools or frames has moves without a unique pose. Each of
// these calls gets a copy of the routine, in which each move has one pose.

namespace armtrue {

/// A call of a routine of the program, and what it hands on.
struct RoutineCall {
  size_t begin = 0, end = 0;  ///< in texts[0]: the name, which that of a copy replaces
  std::string context;        ///< calls with the same share a copy; empty: it is not certain
};

/// A routine of the program.
struct Routine {
  std::string name;
  size_t begin = 0, end = 0;       ///< in texts[0]: whole lines
  std::string before_name;         ///< what stands before the name in the head of a copy
  size_t head_end = 0;             ///< behind its name
  bool depends_on_caller = false;  ///< a move in it is left alone for what its calls hand on
  bool has_other_callers = false;  ///< known or not: it stays for them
  bool can_be_copied = true;       ///< all that names it here are `calls`
  std::vector<RoutineCall> calls;
};

/// The program with copies of routines, each behind its routine; read again if there are any.
RobotProgram with_routine_copies(RobotProgram program, const KnownFrames& known, TargetParts parts);

/// One of the texts, without copies of routines.
const std::string& text_without_copies(const RobotProgram& program, size_t text);

/// Whether the numbers of a point stand in a copy of a routine.
bool is_in_routine_copy(const RobotProgram& program, const ProgramPoint& point);

/// A place of texts[0] in RobotProgram::without_copies. In a copy: where the copy begins.
size_t place_without_copies(const RobotProgram& program, size_t place);

/// Edits of texts[0] as edits of RobotProgram::without_copies. A copy whose edits are those of its
/// routine is left out. `kept`: the others, by their index.
std::vector<TextEdit> edits_without_copies(const RobotProgram& program,
                                           const std::vector<TextEdit>& edits,
                                           std::vector<size_t>& kept);

}  // namespace armtrue
