#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "programs/program_flow.h"
#include "programs/text_cursor.h"

namespace armtrue {

/// Collects the order in which the statements of a KRL program run, for ProgramFlow (KUKA, KSS 8.x
/// operating and programming instructions, program execution control).
class KrlSteps {
 public:
  /// A statement that begins at `at` with `word` in capitals; `rest` stands behind the word.
  void pass(const std::string& word, size_t at, TextCursor rest);
  /// A call that runs at `at`, of a statement or of a function in an expression.
  void pass_call(const std::string& name, size_t at);

  /// The names that the text calls, in capitals.
  const std::set<std::string>& called() const { return called_; }
  /// Those that INTERRUPT DECL or TRIGGER calls, at any time from these places on.
  const std::map<std::string, std::vector<size_t>>& interrupts() const { return interrupts_; }
  const ProgramFlow& flow() const { return flow_; }

 private:
  ProgramFlow flow_;
  std::set<std::string> called_;
  std::map<std::string, std::vector<size_t>> interrupts_;
};

}  // namespace armtrue
