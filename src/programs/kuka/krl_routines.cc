#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "programs/kuka/krl_parts.h"
#include "programs/kuka/krl_set_up.h"
#include "programs/kuka/krl_syntax.h"
#include "programs/kuka/krl_words.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

class KrlRoutineReader {
 public:
  KrlRoutineReader(const RobotProgram& program, const KnownFrames& known)
      : src_(program.texts[0].text),
        text_(masked(src_, ';', "\"")),
        syntax_(parse_krl(program)),
        set_ups_(src_, syntax_, program.neighbours, known, frames_, warnings_) {}

  std::vector<Routine> read() {
    moves_ = set_ups_.read().of_moves;
    const std::vector<Statement> lines = lines_of(text_);
    for (const Statement& line : lines) read_definition(line);
    for (const Statement& line : lines) read_call(line);
    each_word(text_, {0, 0, text_.size()},
              [&](const std::string& word, size_t, const TextCursor&) { ++words_[word]; });
    for (size_t i = 0; i < routines_.size(); ++i) finish(i);
    note_what_is_left();
    return std::move(routines_);
  }

 private:
  // DEF NAME( ), GLOBAL DEF NAME( ); the first one has the name of the file, and others call it.
  void read_definition(const Statement& line) {
    const std::string word = TextCursor(text_, line.begin, line.end).take_name();
    const bool is_end = word == "END" || word == "ENDFCT";
    if (is_end && !routines_.empty()) routines_.back().end = std::min(line.end + 1, text_.size());
    const auto head = krl_head(text_, line);
    if (!head || !begins_krl_routine(head->word)) return;
    Routine routine;
    routine.begin = line.begin;
    routine.head_end = head->end;
    routine.name = src_.substr(head->begin, head->end - head->begin);
    routine.before_name = "DEF ";
    routine.can_be_copied = head->word == "DEF" && !head->name.empty() && !routines_.empty();
    routine.has_other_callers = head->is_global;
    of_name_.emplace(head->name, routines_.size());
    routines_.push_back(std::move(routine));
  }

  void read_call(const Statement& line) {
    TextCursor cursor(text_, line.begin, line.end);
    cursor.next();
    const size_t begin = cursor.at();
    const auto called = of_name_.find(cursor.take_name());
    if (called == of_name_.end()) return;
    const size_t end = cursor.at();
    if (!cursor.take('(')) return;
    RoutineCall call;
    call.begin = begin;
    call.end = end;
    const KrlSetUps::SetUp set_up = set_ups_.before(begin);
    const auto name_of = [&](int frame) { return frame < 0 ? "" : frames_[frame].name; };
    if (!set_up.is_uncertain)
      call.context = fmt::format("{} {} {}", name_of(set_up.base), name_of(set_up.tool),
                                 set_up.is_external_tcp);
    routines_[called->second].calls.push_back(std::move(call));
  }

  // Any other statement that names it may call it at any time: INTERRUPT DECL .. DO NAME( ).
  void finish(size_t index) {
    Routine& routine = routines_[index];
    const size_t next = index + 1 < routines_.size() ? routines_[index + 1].begin : text_.size();
    const size_t named = words_[upper(routine.name)];
    routine.can_be_copied &=
        routine.end > routine.begin && routine.end <= next && named == routine.calls.size() + 1;
  }

  void note_what_is_left() {
    for (size_t i = 0; i < moves_.size(); ++i) {
      const size_t at = syntax_.moves[i].begin;
      const auto behind = std::ranges::upper_bound(routines_, at, {}, &Routine::begin);
      if (moves_[i].is_uncertain && behind != routines_.begin())
        std::prev(behind)->depends_on_caller = true;
    }
  }

  const std::string& src_;
  const std::string text_;
  const KrlSyntax syntax_;
  std::vector<ProgramFrame> frames_;
  ProgramWarnings warnings_{""};
  KrlSetUps set_ups_;
  std::vector<KrlSetUps::SetUp> moves_;
  std::vector<Routine> routines_;
  std::map<std::string, size_t> of_name_;
  std::map<std::string, int> words_;
};

}  // namespace

std::vector<Routine> krl_routines(const RobotProgram& program, const KnownFrames& known) {
  return KrlRoutineReader(program, known).read();
}

}  // namespace armtrue
