#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "programs/program_flow.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// Labels, jumps, branches and loops of a FANUC program. `text`: by masked_fanuc(), with the moves;
/// `statements`: its lines behind their numbers.
ProgramFlow fanuc_flow(std::string_view text, const std::vector<Statement>& statements);

/// Whether the instructions of a program continue in another one: CALL, RUN.
inline bool calls_fanuc_program(std::string_view word) { return word == "CALL" || word == "RUN"; }

/// An index of a position register: [3], [3,6], [GP1:3,6].
struct FanucIndex {
  std::optional<double> number;  ///< nothing if it is calculated, R[1]
  int element = 0;               ///< from 1; 0: of all elements
  bool is_of_arm = true;         ///< not of another group
};

/// Takes an index and its brackets. Nothing if none stands here.
std::optional<FanucIndex> take_fanuc_index(TextCursor& cursor);

}  // namespace armtrue
