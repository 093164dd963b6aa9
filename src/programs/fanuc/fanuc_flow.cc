#include "programs/fanuc/fanuc_flow.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "programs/fanuc/fanuc_words.h"

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;

// LBL[3] behind its word; nothing of LBL[R[1]].
std::optional<std::string> label_at(TextCursor cursor) {
  const auto number = cursor.take('[') ? cursor.take_number() : std::nullopt;
  return number ? std::optional(fmt::format("{}", *number)) : std::nullopt;
}

void add_steps(std::string_view text, const Statement& statement, ProgramFlow& flow) {
  bool is_block = false;
  std::string first, before;
  each_fanuc_word(text, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
    const bool is_first = first.empty();
    if (is_first) first = at == statement.begin ? word : "=";  // a line of SELECT: =2,JMP LBL[2]
    if (word == "LBL") {
      const auto name = label_at(cursor);
      const bool is_certain = before == "JMP" && (first == "JMP" || first == "IF");
      if (is_first)
        flow.add(Step::label, at, name.value_or(""));
      else if (name && is_certain)
        flow.add(Step::go_to, at, *name);
      else
        flow.add(Step::jump, at);
      if (is_certain && !name) flow.add(Step::stop, at);  // LBL[R[1]]: elsewhere for certain
    } else if (is_first && (word == "ENDFOR" || word == "ENDIF")) {
      flow.add(Step::end_block, at);
    } else if (is_first && (word == "END" || word == "ABORT")) {
      flow.add(word == "END" ? Step::leave : Step::stop, at);
    } else if (is_first && word == "FOR") {
      flow.add(Step::loop, at);
    } else if (is_first && word == "ELSE" && cursor.next() != ',') {  // else of SELECT
      flow.add(Step::otherwise, at);
    }
    is_block |= word == "THEN";
    before = word;
  });
  if (first != "IF") return;
  flow.add(Step::branch, statement.begin);
  if (!is_block) flow.add(Step::end_block, statement.end);
}

}  // namespace

ProgramFlow fanuc_flow(std::string_view text, const std::vector<Statement>& statements) {
  ProgramFlow flow;
  for (const Statement& statement : statements) add_steps(text, statement, flow);
  return flow;
}

std::optional<FanucIndex> take_fanuc_index(TextCursor& cursor) {
  if (!cursor.take('[')) return std::nullopt;
  FanucIndex index;
  const std::string group = cursor.take_name();
  const bool is_group = group.starts_with("GP") && cursor.take(':');
  index.is_of_arm = !is_group || group == "GP1";
  if (group.empty() || is_group) index.number = cursor.take_number();
  cursor.skip_to(",]\n");
  if (index.number && cursor.take(',')) {
    constexpr double kMostAxes = 9;
    const auto element = cursor.take_number();
    if (element && *element >= 1 && *element <= kMostAxes && *element == std::floor(*element))
      index.element = static_cast<int>(*element);
    else
      index.number.reset();
  }
  for (int depth = 1; depth > 0 && !cursor.done() && cursor.next() != '\n'; cursor.step())
    depth += cursor.next() == '[' ? 1 : cursor.next() == ']' ? -1 : 0;
  return index;
}

}  // namespace armtrue
