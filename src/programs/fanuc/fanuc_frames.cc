#include "programs/fanuc/fanuc_frames.h"

#include <algorithm>
#include <string>

#include "programs/fanuc/fanuc_words.h"

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;
constexpr int kAny = -1;
constexpr double kMost = 1000;

}  // namespace

FanucFrames::FanucFrames(std::string_view text, const std::vector<Statement>& statements) {
  for (const Statement& statement : statements) read_statement(text, statement);
  displaced_ = flow_.follow(displacements_, 0);
  for (Kind* kind : {&frames_, &tools_}) {
    kind->active = flow_.follow(kind->numbers, ProgramFlow::kUncertain);
    const std::vector<ProgramFlow::Setting> of_any = kind->changes[kAny];
    for (auto& [number, changes] : kind->changes) {
      if (number != kAny) changes.insert(changes.end(), of_any.begin(), of_any.end());
      const auto is_known = [](const ProgramFlow::Setting& change) { return change.value > 0; };
      if (std::ranges::any_of(changes, is_known))
        changes.insert(changes.end(), calls_.begin(), calls_.end());
      kind->changed[number] = flow_.follow(changes, 0);
    }
  }
}

// What a program that is called selects stays active.
void FanucFrames::read_statement(std::string_view text, const Statement& statement) {
  read_steps(text, statement);
  line_ = statement.line;
  if (read_element(text, statement)) return;
  // Touch Offset PR[32], Touch Offset End
  TextCursor words(text, statement.begin, statement.end);
  if (words.take_name() == "TOUCH" && words.take_name() == "OFFSET")
    displacements_.push_back({statement.begin, words.take_name() == "END" ? 0 : 1});
  each_fanuc_word(text, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
    const bool is_first = at == statement.begin;
    if (word == "CALL" || word == "RUN") calls_.push_back({at, ProgramFlow::kUncertain});
    for (const bool is_tool : {false, true}) {
      Kind& of_word = is_tool ? tools_ : frames_;
      const std::string name = is_tool ? "UTOOL" : "UFRAME", variable = "$MN" + name;
      if (word == "CALL" || word == "RUN")
        of_word.numbers.push_back({at, ProgramFlow::kUncertain});
      else if (word == name || word == variable)
        read_setting(of_word, false, at, is_first, cursor);
      else if (word == name + "_NUM" || word == variable + "NUM")
        read_setting(of_word, true, at, is_first, cursor);
    }
  });
  elements_.clear();
}

// PR[9,3]=40.5
bool FanucFrames::read_element(std::string_view text, const Statement& statement) {
  TextCursor cursor(text, statement.begin, statement.end);
  if (cursor.take_name() != "PR" || !cursor.take('[')) return false;
  const auto number = cursor.take_number();
  const auto element = number && cursor.take(',') ? cursor.take_number() : std::nullopt;
  if (!element || !cursor.take(']') || !cursor.take('=')) return false;
  const auto value = cursor.take_number();
  cursor.take(';');
  if (!value || !cursor.done()) return false;
  if (register_ != *number) elements_.clear();
  register_ = *number;
  elements_[*element] = *value;
  return true;
}

// PR[9] whose elements the lines before have set: it is added to the values.
int FanucFrames::value_of(Kind& kind, TextCursor cursor) const {
  if (cursor.take_name() != "PR" || !cursor.take('[')) return ProgramFlow::kUncertain;
  const auto number = cursor.take_number();
  if (!number || *number != register_ || !cursor.take(']') || cursor.next() != ';')
    return ProgramFlow::kUncertain;
  SetFrame frame{line_, {}};
  constexpr int kNumbers = 6;
  for (int element = 1; element <= kNumbers; ++element) {
    const auto found = elements_.find(element);
    if (found == elements_.end()) return ProgramFlow::kUncertain;
    frame.numbers.push_back(found->second);
  }
  kind.values.push_back(frame);
  return static_cast<int>(kind.values.size());
}

// UFRAME_NUM=2, UFRAME[2]=PR[1], $MNUFRAMENUM[1]=2, $MNUFRAME[1,2]=.. of a group. Behind a
// condition, which may hold the same words, the value is not certain.
void FanucFrames::read_setting(Kind& kind, bool is_number, size_t at, bool is_first,
                               TextCursor cursor) {
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
        {at, may_be_known ? value_of(kind, cursor) : ProgramFlow::kUncertain});
    return;
  }
  const auto value = is_indexed || !is_first ? std::nullopt : cursor.take_number();
  const bool is_plain = value && cursor.next() == ';' && *value >= 0 && *value < kMost;
  kind.numbers.push_back({at, is_plain ? static_cast<int>(*value) : ProgramFlow::kUncertain});
}

void FanucFrames::read_steps(std::string_view text, const Statement& statement) {
  bool is_block = false;
  std::string first;
  each_fanuc_word(text, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
    const bool is_first = first.empty();
    if (is_first) first = word;
    if (is_first && word == "LBL")
      flow_.add(Step::label, at);
    else if (word == "JMP" || word == "LBL")
      flow_.add(Step::jump, at);
    else if (is_first && (word == "ENDFOR" || word == "ENDIF"))
      flow_.add(Step::end_block, at);
    else if (is_first && word == "FOR")
      flow_.add(Step::loop, at);
    else if (is_first && word == "ELSE" && cursor.next() != ',')  // else of SELECT
      flow_.add(Step::otherwise, at);
    is_block |= word == "THEN";
  });
  if (first != "IF") return;
  flow_.add(Step::branch, statement.begin);
  if (!is_block) flow_.add(Step::end_block, statement.end);
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
