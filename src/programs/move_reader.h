#pragma once

#include <string>

#include "armtrue/programs/robot_program.h"
#include "programs/program_warnings.h"

namespace armtrue {

/// Common to the readers of all makers: a move becomes targets, or is left alone.
class MoveReader {
 protected:
  explicit MoveReader(RobotProgram& program)
      : program_(program), warnings_(program.texts[0].name, program.lines) {}

  /// Leaves a move alone. `may_run`: false if no way through the text leads to it; then it does not
  /// count.
  void leave_move(int line, const std::string& reason, bool may_run = true);
  /// The number of a line of the text, without copies of routines.
  int counted_line(int line) const {
    return program_.lines.empty() ? line : program_.lines[line - 1];
  }
  /// Adds a target at a point of the program: its kind, and its pose or joint angles, are those of
  /// the point's numbers.
  ProgramTarget& add_target_at(ProgramTarget target, int point);
  /// Of a move of joints, lines or arcs: J, L, C. `is_last`: of its points.
  static MotionKind motion_of(char kind, bool is_last);

  RobotProgram& program_;
  ProgramWarnings warnings_;
};

}  // namespace armtrue
