#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "programs/move_reader.h"
#include "programs/program_flow.h"
#include "programs/scoped_names.h"
#include "programs/statement.h"

namespace armtrue {

/// A parameter of a URScript function.
struct UrParameter {
  std::string name;
  size_t at = 0;  ///< in the head
  int scope = 0;  ///< of the function
  RoutineParameter parameter;
};

/// The functions and threads of a URScript program, and how it runs through them.
struct UrStructure {
  Scopes scopes;
  ProgramFlow flow;
  std::vector<UrParameter> parameters;
  /// By begin and end: functions and threads within others that nothing calls or runs, or only such
  /// functions (libraries and subprograms that PolyScope writes into each program), and what stands
  /// behind `halt` or `return` in its function.
  std::vector<std::pair<size_t, size_t>> never_run;
  std::optional<size_t> open;  ///< where the first function begins that has no end
};

/// Functions that drive the arm, in capitals: moves, and others that are not followed.
bool is_ur_move(const std::string& word);
bool is_other_ur_motion(const std::string& word);

/// `text`: by masked(); `statements`: its statements.
UrStructure structure_of_urscript(std::string_view text, const std::vector<Statement>& statements);

}  // namespace armtrue
