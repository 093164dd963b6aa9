#include "programs/abb/rapid_flow.h"

#include <algorithm>
#include <optional>

#include "programs/abb/rapid_words.h"

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;

class RapidFlowReader {
 public:
  explicit RapidFlowReader(std::string_view text) : text_(text) {}

  RapidFlow read(const std::vector<Statement>& statements) {
    read_steps(statements);
    return {flow_.follow(displacements_, 0),
            flow_.follow(turnings_, static_cast<int>(ArcTurning::with_path)),
            flow_.follow(confj_, 1), flow_.follow(confl_, 1), flow_};
  }

  // `modules`: where each begins in the text.
  RapidDisplacements read_displacements(const std::vector<Statement>& statements,
                                        const std::vector<size_t>& modules) {
    read_steps(statements);
    call_what_nothing_calls();
    const ProgramFlow::Values displacement = flow_.follow(displacements_, 0);
    const auto module_at = [&](size_t at) { return std::ranges::upper_bound(modules, at); };
    RapidDisplacements result;
    for (const auto& [at, name] : calls_) {
      const bool is_own = std::ranges::any_of(
          routines_.at(name), [&](size_t routine) { return module_at(routine) == module_at(at); });
      if (is_own) continue;
      const int before = displacement.at(at - 1), behind = displacement.at(at);
      if (before != ProgramFlow::kUncertain) result.called_with[name].insert(before);
      if (behind != ProgramFlow::kUncertain && behind != before)
        result.leaving[name].insert(behind);
    }
    return result;
  }

 private:
  void read_steps(const std::vector<Statement>& statements) {
    for (const Statement& statement : statements)
      each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
        if (begins_rapid_routine(word)) routines_[take_rapid_routine(word, cursor)].push_back(at);
        return false;
      });
    for (const Statement& statement : statements) read_statement(statement);
  }

  // Without a displacement: what one of them leaves is not there when another one begins.
  void call_what_nothing_calls() {
    std::set<std::string> called;
    for (const auto& [at, name] : calls_) called.insert(name);
    size_t place = text_.size();
    flow_.add(Step::routine, ++place);
    for (const auto& [name, places] : routines_) {
      if (called.contains(name)) continue;
      displacements_.push_back({++place, 0});
      flow_.add(Step::call, ++place, name);
    }
    flow_.add(Step::end_routine, ++place);
  }

  void read_statement(const Statement& statement) {
    bool is_then_of_elseif = false, is_compact = false;
    each_rapid_word(text_, statement, [&](const std::string& word, size_t at, TextCursor& cursor) {
      if (begins_rapid_routine(word)) {
        TextCursor head = cursor;
        flow_.add(word == "TRAP" ? Step::interrupt : Step::routine, at,
                  take_rapid_routine(word, head));
      } else if (ends_rapid_routine(word)) {
        flow_.add(Step::end_routine, at);
      } else if (word == "IF") {
        if (is_compact) flow_.add(Step::end_block, at);
        is_compact = true;  // unless a THEN follows
        flow_.add(Step::branch, at);
      } else if (word == "ELSEIF") {
        is_then_of_elseif = true;
        flow_.add(Step::alternative, at);
      } else if (word == "THEN") {
        if (!is_then_of_elseif) is_compact = false;
        is_then_of_elseif = false;
      } else if (word == "WHILE") {
        TextCursor condition = cursor;
        flow_.add(condition.take_name() == "TRUE" ? Step::repeat : Step::loop, at);
      } else if (word == "GOTO") {
        TextCursor target = cursor;
        flow_.add(Step::go_to, at, target.take_name());
      } else if (const auto step = block_step(word)) {
        flow_.add(*step, at);
        if (*step == Step::jump) flow_.add(Step::stop, at);  // for certain
      } else if (word == "CALLBYVAR") {
        flow_.add(Step::call, at);
      } else if (routines_.contains(word)) {
        flow_.add(Step::call, at, word);
        calls_.emplace_back(at, word);
      } else if (word == "CIRPATHMODE") {
        turnings_.push_back({at, static_cast<int>(rapid_turning(cursor))});
      } else if (word == "CONFJ" || word == "CONFL") {
        (word == "CONFJ" ? confj_ : confl_).push_back({at, states_off(cursor) ? 0 : 1});
      } else if (word == "PDISPON" || word == "PDISPSET" || word == "PDISPOFF") {
        displacements_.push_back({at, word == "PDISPOFF" ? 0 : 1});
      } else if (cursor.next() == ':') {
        TextCursor behind = cursor;
        behind.take(':');
        if (behind.next() != '=') flow_.add(Step::label, at, word);
      }
      return false;
    });
    // %"part"+name%;
    const std::string_view whole = text_.substr(statement.begin, statement.end - statement.begin);
    if (const size_t late = whole.find("%\""); late != std::string_view::npos)
      flow_.add(Step::call, statement.begin + late);
    if (is_compact) flow_.add(Step::end_block, statement.end);
  }

  static bool states_off(TextCursor cursor) {
    return cursor.take('\\') && cursor.take_name() == "OFF";
  }

  static std::optional<Step> block_step(const std::string& word) {
    static const std::map<std::string, Step> kSteps{
        {"ELSE", Step::otherwise},    {"CASE", Step::alternative}, {"DEFAULT", Step::otherwise},
        {"TEST", Step::choice},       {"FOR", Step::loop},         {"ENDIF", Step::end_block},
        {"ENDTEST", Step::end_block}, {"ENDFOR", Step::end_block}, {"ENDWHILE", Step::end_block},
        {"RETURN", Step::leave},      {"EXIT", Step::stop},        {"EXITCYCLE", Step::stop},
        {"RAISE", Step::jump},        {"RETRY", Step::jump},       {"TRYNEXT", Step::jump},
        {"ERROR", Step::handler},     {"UNDO", Step::handler},     {"BACKWARD", Step::handler}};
    const auto found = kSteps.find(word);
    return found == kSteps.end() ? std::nullopt : std::optional(found->second);
  }

  std::string_view text_;
  std::map<std::string, std::vector<size_t>> routines_;  // and where they begin
  std::vector<std::pair<size_t, std::string>> calls_;    // that name a routine
  ProgramFlow flow_;
  std::vector<ProgramFlow::Setting> displacements_, turnings_, confj_, confl_;
};

}  // namespace

RapidFlow follow_rapid(std::string_view text, const std::vector<Statement>& statements) {
  return RapidFlowReader(text).read(statements);
}

RapidDisplacements follow_rapid_displacements(const std::vector<RapidModuleText>& modules) {
  std::string text;
  std::vector<Statement> statements;
  std::vector<size_t> begins;
  for (const RapidModuleText& module : modules) {
    const size_t begin = text.size();
    begins.push_back(begin);
    for (const Statement& statement : module.statements)
      statements.push_back({statement.line, begin + statement.begin, begin + statement.end});
    text += module.text;
  }
  const std::string capitals = upper(text);
  if (capitals.find("PDISPON") == std::string::npos &&
      capitals.find("PDISPSET") == std::string::npos)
    return {};
  return RapidFlowReader(text).read_displacements(statements, begins);
}

}  // namespace armtrue
