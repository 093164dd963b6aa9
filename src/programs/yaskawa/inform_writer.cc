#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/yaskawa/inform_parts.h"
#include "programs/yaskawa/inform_positions.h"

namespace armtrue {
namespace {

constexpr size_t kMaxLines = 9999;  // of the instructions of a job (DX100, YRC1000)

size_t count_of_lines(std::string_view text) {
  const size_t begin = std::min(line_that_begins(text, "//INST"), text.size());
  return std::ranges::count(text.substr(begin), '\n');
}

class InformWriter : public MoveWriter {
 public:
  explicit InformWriter(const RobotProgram& program) : MoveWriter(program) {
    const std::string plain = masked(text_, '\'', "\"");
    for (const auto& [name, position] :
         inform_positions(std::string_view(plain).substr(0, line_that_begins(plain, "//INST")))) {
      heads_[position.begin] = position.heads;
      if (name[0] != 'C') continue;
      constexpr double kHighest = 1e9;  // of a number that is read; controllers stop far below
      const double number = std::min(read_number(name.substr(1)).value_or(0), kHighest);
      number_ = std::max(number_, static_cast<unsigned long>(number));
      if (position.begin < last_) continue;
      last_ = position.begin;
      width_ = text_.find('=', position.begin) - position.begin - 1;
      while (width_ > 1 && is_blank(text_[position.begin + width_])) --width_;
    }
    if (heads_.contains(last_)) written_ = heads_[last_];
    // A job of variables alone: before the first of them.
    const bool has_steps = heads_.contains(last_) && text_[last_] == 'C';
    place_ = has_steps        ? std::min(text_.find('\n', last_), text_.size() - 1) + 1
             : heads_.empty() ? text_.size()
                              : heads_.begin()->first;
    if (!has_steps && !heads_.empty()) written_ = heads_.begin()->second;
    at_place_ = written_;
  }

  std::string inserted_point(const ProgramPoint& point,
                             const std::vector<TextEdit>& changes) override {
    const std::string whole = changed(point, changes);
    const InformHeads& heads = heads_.at(point.begin);
    const std::string end = line_end(text_, point.begin);
    std::string key = heads.change_from({}, end) + whole.substr(whole.find('='));
    const auto [known, is_new] = numbers_.try_emplace(std::move(key), number_ + 1);
    const std::string name = fmt::format("C{:0{}}", known->second, width_);
    if (!is_new) return name;
    ++number_;
    positions_ += heads.change_from(written_, end) + name + whole.substr(whole.find('=')) + end;
    written_ = heads;
    return name;
  }

 private:
  void finish() override {
    if (numbers_.empty()) return;
    positions_ += at_place_.change_from(written_, line_end(text_, place_ > 0 ? place_ - 1 : 0));
    replace(place_, place_, positions_);
    // ///NPOS 3,0,0,0,0,0
    const size_t line = line_that_begins(text_, "///NPOS");
    if (line == std::string::npos) return;
    TextCursor cursor(text_, line + 7, std::min(text_.find('\n', line), text_.size()));
    cursor.next();
    const size_t begin = cursor.at();
    if (const auto count = cursor.take_number())
      replace(begin, cursor.at(), fmt::format("{}", *count + static_cast<double>(numbers_.size())));
  }

  std::map<size_t, InformHeads> heads_;  // of each position, by where it begins
  InformHeads written_, at_place_;       // that hold behind what is written; where it is inserted
  size_t last_ = 0, place_ = 0;          // the last C; where new ones stand
  unsigned long number_ = 0;             // of the last one
  size_t width_ = 5;                     // its digits
  std::map<std::string, unsigned long> numbers_;  // of new ones, by what they state
  std::string positions_;
};

}  // namespace

std::unique_ptr<MoveWriter> inform_writer(const RobotProgram& program) {
  return std::make_unique<InformWriter>(program);
}

void refuse_long_inform_job(const RobotProgram& program, size_t inserted) {
  const size_t lines = count_of_lines(program.texts[0].text);
  if (inserted == 0 || lines + inserted <= kMaxLines) return;
  throw InputError(fmt::format(
      "{}: has {} lines and {} inserted ones, and a Yaskawa controller loads {} of a job; split it "
      "into jobs that one calls after the other (CALL), and correct each, or take a larger "
      "tolerance between points",
      program.texts[0].name, lines, inserted, kMaxLines));
}

void add_inform_comment(const std::string& comment, std::string& text) {
  size_t place = line_that_begins(text, "//INST");
  for (const Statement& line : lines_of(text, place)) {
    TextCursor cursor(text, line.begin, line.end);
    const bool is_head = cursor.next() == '/';
    const bool is_nop = cursor.take_name() == "NOP";
    if (is_head || is_nop) place = line.end + 1;
    if (!is_head) break;
  }
  if (place > text.size()) return;  // no instructions
  text.insert(place, comment + line_end(text, 0));
}

}  // namespace armtrue
