#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/program_flow.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"

namespace armtrue {

/// A parameter of a routine, by its place among those that each call gives.
struct RoutineParameter {
  std::string routine;
  size_t position = 0;
  bool operator==(const RoutineParameter&) const = default;
};

/// A call and what it hands over.
struct HandingCall {
  std::string routine;
  int line = 0;
  std::vector<Statement> arguments;
  bool may_run = true;
};

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
  /// Follows points that calls hand to routines. The target of a call is what it hands over: there
  /// the point is declared or written out. Move: has a RoutineParameter to which it goes, a line
  /// and whether it may run. Follower: only_moves_use(parameter): nothing else counts on the point
  /// as it is; read_handed(call, argument, moves): reads all moves that go to an argument;
  /// keep(argument): its points must stay. A move stays where a call is not followed.
  template <class Move, class Follower>
  void follow_calls(const std::vector<HandingCall>& calls, const std::vector<Move>& moves,
                    const std::string& why_left, Follower& follower) {
    std::vector<char> is_followed(moves.size(), false), is_left(moves.size(), false);
    for (const HandingCall& call : calls) {
      for (size_t i = 0; i < call.arguments.size(); ++i) {
        const RoutineParameter parameter{call.routine, i};
        std::vector<const Move*> to_it;
        for (const Move& move : moves)
          if (move.parameter == parameter) to_it.push_back(&move);
        const bool follows = !to_it.empty() && follower.only_moves_use(parameter);
        if (follows)
          follower.read_handed(call, call.arguments[i], to_it);
        else
          follower.keep(call.arguments[i]);
        for (const Move* const move : to_it)
          (follows ? is_followed : is_left)[static_cast<size_t>(move - moves.data())] = true;
      }
      for (size_t i = 0; i < moves.size(); ++i)
        is_left[i] |= moves[i].parameter.routine == call.routine &&
                      moves[i].parameter.position >= call.arguments.size();
    }
    for (size_t i = 0; i < moves.size(); ++i)
      if (is_left[i] || !is_followed[i]) leave_move(moves[i].line, why_left, moves[i].may_run);
    std::ranges::stable_sort(program_.targets, {}, &ProgramTarget::begin);
  }
  /// Finds the ways between all targets. `flow`: all steps.
  void find_ways(const ProgramFlow& flow);
  /// Whether two moves would drive to the same point with the same joint angles: in the same frame,
  /// with the same tool.
  static bool drives_alike(const ProgramTarget& a, const ProgramTarget& b);
  /// Of a move of joints, lines or arcs: J, L, C. `is_last`: of its points.
  static MotionKind motion_of(char kind, bool is_last);

  RobotProgram& program_;
  ProgramWarnings warnings_;
};

}  // namespace armtrue
