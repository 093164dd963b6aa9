#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

/// What a RAPID program has set at each place.
struct RapidFlow {
  /// 1: a program displacement (PDispOn, PDispSet) is active; 0: none is.
  ProgramFlow::Values displacement;
  /// ArcTurning (CirPathMode).
  ProgramFlow::Values turning;
  /// Whether the confdata of joint moves (ConfJ), and of straight and circular ones (ConfL), count:
  /// 1, or 0 behind \Off, where the arm moves to the nearest posture.
  ProgramFlow::Values confj, confl;
  ProgramFlow steps;
};

/// `text`: by masked(); `statements`: its statements.
RapidFlow follow_rapid(std::string_view text, const std::vector<Statement>& statements);

/// How program displacements cross the modules of a task: values of RapidFlow::displacement that
/// are certain, by routines that other modules call. Much is not certain behind a handler of
/// errors.
struct RapidDisplacements {
  std::map<std::string, std::set<int>> called_with;
  std::map<std::string, std::set<int>> leaving;  ///< by calls that leave another one
};
struct RapidModuleText {
  std::string_view text;  ///< by masked()
  const std::vector<Statement>& statements;
};
RapidDisplacements follow_rapid_displacements(const std::vector<RapidModuleText>& modules);

}  // namespace armtrue
