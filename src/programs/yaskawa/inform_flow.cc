#include "programs/yaskawa/inform_flow.h"

#include <map>
#include <optional>

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;

std::optional<Step> block_step(const std::string& word) {
  static const std::map<std::string, Step> kSteps{{"IFTHEN", Step::branch},
                                                  {"IFTHENEXP", Step::branch},
                                                  {"ELSE", Step::alternative},
                                                  {"ELSEIF", Step::alternative},
                                                  {"ELSEIFEXP", Step::alternative},
                                                  {"ENDIF", Step::end_block},
                                                  {"SWITCH", Step::branch},
                                                  {"CASE", Step::alternative},
                                                  {"DEFAULT", Step::alternative},
                                                  {"ENDSWITCH", Step::end_block},
                                                  {"WHILE", Step::loop},
                                                  {"WHILEEXP", Step::loop},
                                                  {"ENDWHILE", Step::end_block},
                                                  {"FOR", Step::loop},
                                                  {"NEXT", Step::end_block}};
  const auto found = kSteps.find(word);
  return found == kSteps.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

InformFlow follow_inform(std::string_view text, const std::vector<Statement>& statements) {
  ProgramFlow flow;
  std::vector<ProgramFlow::Setting> shifts;
  for (const Statement& statement : statements) {
    TextCursor cursor(text, statement.begin, statement.end);
    if (cursor.take('*')) {
      flow.add(Step::label, statement.begin, cursor.take_name());
      continue;
    }
    const std::string word = cursor.take_name();
    bool is_conditional = false;
    each_word(text, statement, [&](const std::string& other, size_t, const TextCursor&) {
      is_conditional |= other == "IF";
    });
    if (const auto step = block_step(word)) {
      flow.add(*step, statement.begin);
    } else if (word == "JUMP") {
      const bool is_label = cursor.take('*');
      const std::string name = cursor.take_name();
      if (is_conditional)
        flow.add(Step::jump, statement.begin);
      else
        flow.add(is_label ? Step::go_to : Step::leave, statement.begin, name);
    } else if (word == "RET" || word == "END") {
      flow.add(is_conditional ? Step::jump : Step::leave, statement.begin);
    } else if (word == "SFTON" || word == "SFTOF") {
      shifts.push_back({statement.begin, word == "SFTON" ? 1 : 0});
    }
  }
  return {flow, flow.follow(shifts, 0)};
}

}  // namespace armtrue
