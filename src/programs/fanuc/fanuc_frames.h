#pragma once

#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

/// Frames of a FANUC program as it runs: which user frame and tool are active (UFRAME_NUM,
/// UTOOL_NUM), which it changes (UFRAME[..]=, UTOOL[..]=), and where moves are displaced (Touch
/// Offset).
class FanucFrames {
 public:
  /// `text`: by masked_fanuc(), with the moves; `statements`: its lines behind their numbers.
  FanucFrames(std::string_view text, const std::vector<Statement>& statements);

  /// The number of the active frame or tool at a place; nothing if it is not certain.
  std::optional<int> active(bool is_tool, size_t at) const;
  /// Whether the program may have changed a frame or tool at a place.
  bool is_changed(bool is_tool, int number, size_t at) const;
  /// Whether moves at a place are, or may be, displaced by what the arm has touched.
  bool is_displaced(size_t at) const { return displaced_.at(at) != 0; }

 private:
  // Of user frames or of tools.
  struct Kind {
    std::vector<ProgramFlow::Setting> numbers;
    std::map<int, std::vector<ProgramFlow::Setting>> changes;  // by number; -1: of any
    ProgramFlow::Values active;
    std::map<int, ProgramFlow::Values> changed;
  };

  void read_statement(std::string_view text, const Statement& statement);
  void read_steps(std::string_view text, const Statement& statement);
  void read_setting(Kind& kind, bool is_number, size_t at, bool is_first, TextCursor cursor);
  const Kind& kind(bool is_tool) const { return is_tool ? tools_ : frames_; }

  ProgramFlow flow_;
  Kind frames_, tools_;
  std::vector<ProgramFlow::Setting> displacements_;
  ProgramFlow::Values displaced_;
};

}  // namespace armtrue
