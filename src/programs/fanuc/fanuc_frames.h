#pragma once

#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "programs/fanuc/fanuc_assignments.h"
#include "programs/program_flow.h"
#include "programs/statement.h"

namespace armtrue {

/// Frames of a FANUC program as it runs: which user frame and tool are active (UFRAME_NUM,
/// UTOOL_NUM), which it changes (UFRAME[..]=, UTOOL[..]=), and where moves are displaced (Touch
/// Offset). A program that it calls may do the same, unless `listed` knows that it does not.
class FanucFrames {
 public:
  /// `text`, `statements`: as of fanuc_flow(), which gives `flow`.
  FanucFrames(std::string_view text, const std::vector<Statement>& statements,
              const ProgramFlow& flow, const FanucAssignments& registers,
              const FanucRegisters& listed);

  /// The number of the active frame or tool at a place; nothing if it is not certain.
  std::optional<int> active(bool is_tool, size_t at) const;
  /// Whether the program may have given a frame or tool at a place a value that is not known.
  bool is_changed(bool is_tool, int number, size_t at) const;
  struct SetFrame {
    int line = 0;
    std::vector<double> numbers;  ///< X Y Z W P R [mm, deg]
  };
  /// What the program has given a frame or tool at a place, if that is known: UTOOL[9]=PR[9], with
  /// no call since. Null if not.
  const SetFrame* set_value(bool is_tool, int number, size_t at) const;
  /// Whether moves at a place are, or may be, displaced by what the arm has touched.
  bool is_displaced(size_t at) const { return displaced_.at(at) != 0; }
  struct Condition {
    double id = 0;         ///< of the register
    size_t statement = 0;  ///< where that is stated
  };
  /// The register of OFFSET CONDITION or TOOL_OFFSET CONDITION at a place; nothing if it is not
  /// certain.
  std::optional<Condition> condition(bool is_tool, size_t at) const;

 private:
  // Of user frames or of tools.
  struct Kind {
    std::vector<ProgramFlow::Setting> numbers;
    // By number; -1: of any. The value is that of values, counted from 1.
    std::map<int, std::vector<ProgramFlow::Setting>> changes;
    std::vector<SetFrame> values;
    ProgramFlow::Values active;
    std::vector<ProgramFlow::Setting> conditions;  // the value is an index of conditions_
    ProgramFlow::Values condition;
    std::map<int, ProgramFlow::Values> changed;
  };

  void read_statement(std::string_view text, const Statement& statement,
                      const FanucRegisters& listed);
  void read_setting(Kind& kind, bool is_number, size_t at, const Statement& statement,
                    TextCursor cursor);
  void read_condition(Kind& kind, const Statement& statement, TextCursor cursor);
  int value_of(Kind& kind, const Statement& statement, TextCursor cursor) const;
  int change_at(bool is_tool, int number, size_t at) const;
  const Kind& kind(bool is_tool) const { return is_tool ? tools_ : frames_; }

  const FanucAssignments& registers_;
  Kind frames_, tools_;
  std::vector<Condition> conditions_;
  std::vector<ProgramFlow::Setting> calls_;  // of programs that may set frames
  std::vector<ProgramFlow::Setting> displacements_;
  ProgramFlow::Values displaced_;
};

}  // namespace armtrue
