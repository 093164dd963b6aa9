#include "programs/kuka/krl_steps.h"

#include <optional>

#include "programs/kuka/krl_words.h"

namespace armtrue {
namespace {

using Step = ProgramFlow::Step;

std::optional<Step> step_of(const std::string& word) {
  static const std::map<std::string, Step> kSteps{
      {"DEF", Step::routine},        {"DEFFCT", Step::routine},      {"END", Step::end_routine},
      {"ENDFCT", Step::end_routine}, {"IF", Step::branch},           {"SWITCH", Step::choice},
      {"ELSE", Step::otherwise},     {"CASE", Step::alternative},    {"DEFAULT", Step::otherwise},
      {"ENDIF", Step::end_block},    {"ENDSWITCH", Step::end_block}, {"EXIT", Step::exit_loop},
      {"GOTO", Step::go_to},         {"RETURN", Step::leave},        {"RESUME", Step::jump}};
  if (word == "LOOP" || word == "REPEAT") return Step::repeat;
  if (begins_krl_loop(word)) return Step::loop;
  if (ends_krl_loop(word)) return Step::end_block;
  const auto found = kSteps.find(word);
  return found == kSteps.end() ? std::nullopt : std::optional(found->second);
}

// .. DO NAME(); empty if there is none.
std::string called_behind_do(TextCursor cursor) {
  while (!cursor.done()) {
    const std::string word = cursor.take_name();
    if (word == "DO") return cursor.take_name();
    if (word.empty()) cursor.step();
  }
  return "";
}

}  // namespace

void KrlSteps::pass(const std::string& word, size_t at, TextCursor rest) {
  if (word == "INTERRUPT" || word == "TRIGGER") {
    interrupts_[called_behind_do(rest)].push_back(at);
  } else if (const auto step = step_of(word)) {
    if (word == "DEFFCT") rest.take_name();  // its type
    const bool is_named = *step == Step::routine || *step == Step::go_to;
    flow_.add(*step, at, is_named ? rest.take_name() : "");
  } else if (!word.empty() && rest.next() == '(') {
    pass_call(word, at);
  } else if (!word.empty() && rest.take(':') && rest.done()) {
    flow_.add(Step::label, at, word);
  }
}

void KrlSteps::pass_call(const std::string& name, size_t at) {
  called_.insert(name);
  flow_.add(Step::call, at, name);
}

}  // namespace armtrue
