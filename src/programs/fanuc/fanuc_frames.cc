#include "programs/fanuc/fanuc_frames.h"

#include <algorithm>
#include <string>

#include "programs/fanuc/fanuc_words.h"

namespace armtrue {
namespace {

constexpr int kAny = -1;
constexpr double kMost = 1000;

}  // namespace

FanucFrames::FanucFrames(std::string_view text, const std::vector<Statement>& statements,
                         const ProgramFlow& flow, const FanucAssignments& registers,
                         const FanucRegisters& listed)
    : registers_(registers) {
  for (const Statement& statement : statements) read_statement(text, statement, listed);
  displaced_ = flow.follow(displacements_, 0);
  for (Kind* kind : {&frames_, &tools_}) {
    kind->active = flow.follow(kind->numbers, ProgramFlow::kUncertain);
    if (!kind->conditions.empty())
      kind->conditions.insert(kind->conditions.end(), calls_.begin(), calls_.end());
    kind->condition = flow.follow(kind->conditions, ProgramFlow::kUncertain);
    const std::vector<ProgramFlow::Setting> of_any = kind->changes[kAny];
    for (auto& [number, changes] : kind->changes) {
      if (number != kAny) changes.insert(changes.end(), of_any.begin(), of_any.end());
      const auto is_known = [](const ProgramFlow::Setting& change) { return change.value > 0; };
      if (std::ranges::any_of(changes, is_known))
        changes.insert(changes.end(), calls_.begin(), calls_.end());
      kind->changed[number] = flow.follow(changes, 0);
    }
  }
}

// What a program that is called selects stays active.
void FanucFrames::read_statement(std::string_view text, const Statement& statement,
                                 const FanucRegisters& listed) {
  // Touch Offset PR[32], Touch Offset End
  TextCursor words(text, statement.begin, statement.end);
  if (words.take_name() == "TOUCH" && words.take_name() == "OFFSET")
    displacements_.push_back({statement.begin, words.take_name() == "END" ? 0 : 1});
  each_fanuc_word(text, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
    if (calls_fanuc_program(word)) {
      if (!listed.may_set_frames(cursor.take_name())) return;
      for (std::vector<ProgramFlow::Setting>* settings :
           {&calls_, &frames_.numbers, &tools_.numbers})
        settings->push_back({at, ProgramFlow::kUncertain});
      return;
    }
    for (const bool is_tool : {false, true}) {
      Kind& of_word = is_tool ? tools_ : frames_;
      if (word == (is_tool ? "TOOL_OFFSET" : "OFFSET") && at == statement.begin)
        read_condition(of_word, statement, cursor);
      const std::string name = is_tool ? "UTOOL" : "UFRAME", variable = "$MN" + name;
      if (word == name || word == variable)
        read_setting(of_word, false, at, statement, cursor);
      else if (word == name + "_NUM" || word == variable + "NUM")
        read_setting(of_word, true, at, statement, cursor);
    }
  });
}

// PR[9], which is added to the values.
int FanucFrames::value_of(Kind& kind, const Statement& statement, TextCursor cursor) const {
  if (cursor.take_name() != "PR") return ProgramFlow::kUncertain;
  const auto index = take_fanuc_index(cursor);
  const auto value =
      index && index->number && index->element == 0 && index->is_of_arm && cursor.next() == ';'
          ? registers_.find(*index->number, statement.begin)
          : std::nullopt;
  if (!value || value->is_joints()) return ProgramFlow::kUncertain;
  kind.values.push_back({statement.line, value->numbers});
  return static_cast<int>(kind.values.size());
}

// OFFSET CONDITION PR[1]; with UFRAME[..] behind it the axes are others.
void FanucFrames::read_condition(Kind& kind, const Statement& statement, TextCursor cursor) {
  if (cursor.take_name() != "CONDITION") return;
  const bool is_register = cursor.take_name() == "PR";
  const auto index = is_register ? take_fanuc_index(cursor) : std::nullopt;
  const bool is_plain = index && index->number && index->element == 0 && cursor.next() == ';';
  if (is_plain) conditions_.push_back({*index->number, statement.begin});
  kind.conditions.push_back({statement.begin, is_plain ? static_cast<int>(conditions_.size()) - 1
                                                       : ProgramFlow::kUncertain});
}

// UFRAME_NUM=2, UFRAME[2]=PR[1], $MNUFRAMENUM[1]=2, $MNUFRAME[1,2]=.. of a group. Behind a
// condition, which may hold the same words, the value is not certain.
void FanucFrames::read_setting(Kind& kind, bool is_number, size_t at, const Statement& statement,
                               TextCursor cursor) {
  const bool is_first = at == statement.begin;
  double number = -1;
  const bool is_indexed = cursor.take('[');
  if (is_indexed) {
    number = cursor.take_number().value_or(-1);
    if (cursor.next() == ',') number = -1;
    cursor.skip_to("=");
  }
  if (!cursor.take('=')) return;
  if (!is_number) {
    const int changed = number >= 0 && number < kMost ? static_cast<int>(number) : kAny;
    const bool may_be_known = changed != kAny && is_first;
    kind.changes[changed].push_back(
        {at, may_be_known ? value_of(kind, statement, cursor) : ProgramFlow::kUncertain});
    return;
  }
  const auto value = is_indexed || !is_first ? std::nullopt : cursor.take_number();
  const bool is_plain = value && cursor.next() == ';' && *value >= 0 && *value < kMost;
  kind.numbers.push_back({at, is_plain ? static_cast<int>(*value) : ProgramFlow::kUncertain});
}

std::optional<FanucFrames::Condition> FanucFrames::condition(bool is_tool, size_t at) const {
  const int index = kind(is_tool).condition.at(at);
  return index == ProgramFlow::kUncertain ? std::nullopt : std::optional(conditions_[index]);
}

std::optional<int> FanucFrames::active(bool is_tool, size_t at) const {
  const int number = kind(is_tool).active.at(at);
  return number == ProgramFlow::kUncertain ? std::nullopt : std::optional(number);
}

// 0 if it is the controller's.
int FanucFrames::change_at(bool is_tool, int number, size_t at) const {
  const std::map<int, ProgramFlow::Values>& changed = kind(is_tool).changed;
  const auto found = changed.find(number);
  return (found == changed.end() ? changed.at(kAny) : found->second).at(at);
}

bool FanucFrames::is_changed(bool is_tool, int number, size_t at) const {
  return change_at(is_tool, number, at) == ProgramFlow::kUncertain;
}

const FanucFrames::SetFrame* FanucFrames::set_value(bool is_tool, int number, size_t at) const {
  const int value = change_at(is_tool, number, at);
  return value > 0 ? &kind(is_tool).values[static_cast<size_t>(value) - 1] : nullptr;
}

}  // namespace armtrue
