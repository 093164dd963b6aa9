#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/text/input_error.h"
#include "programs/fanuc/fanuc_parts.h"
#include "programs/fanuc/fanuc_text.h"
#include "programs/fanuc/fanuc_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

// What a FANUC controller loads: some 32,000 lines a program, and positions whose number fits into
// 16 bits.
constexpr size_t kMaxFanucLines = 32000;
constexpr double kMaxFanucPosition = 32766;

// A line of /MN: `  12:L P[3] ..`.
struct LineOfMoves {
  size_t begin = 0;
  size_t width = 0;              // of the number, with the blanks before it
  std::optional<double> number;  // nothing of a line that continues another
};

std::vector<LineOfMoves> lines_of_moves(std::string_view text) {
  std::vector<LineOfMoves> lines;
  const size_t first = std::min(text.find('\n', line_that_begins(text, "/MN")), text.size());
  const size_t last = std::min(line_that_begins(text, "/POS"), line_that_begins(text, "/END"));
  for (const Statement& line : lines_of(text.substr(0, last), first + 1)) {
    TextCursor cursor(text, line.begin, line.end);
    const auto number = cursor.take_number();
    const size_t behind = cursor.at();
    if (number && cursor.next() == ':')
      lines.push_back({line.begin, behind - line.begin, number});
    else
      lines.push_back({line.begin, 0, std::nullopt});
  }
  return lines;
}

size_t numbered_lines(std::string_view text) {
  return std::ranges::count_if(lines_of_moves(text),
                               [](const LineOfMoves& line) { return line.number.has_value(); });
}

double largest_position(const std::string& text) {
  double largest = 0;
  for (size_t at = text.find("P["); at != std::string::npos; at = text.find("P[", at + 1)) {
    TextCursor cursor(text, at + 2, text.size());
    if (const auto number = cursor.take_number()) largest = std::max(largest, *number);
  }
  return largest;
}

class FanucWriter : public MoveWriter {
 public:
  explicit FanucWriter(const RobotProgram& program)
      : MoveWriter(program), masked_(masked_fanuc(text_)), number_(largest_position(text_)) {}

  std::string inserted_point(const ProgramPoint& point,
                             const std::vector<TextEdit>& changes) override {
    return new_position(point, changes, "]");
  }

  // With the name that the position has in the move.
  std::string own_point(const ProgramTarget& target,
                        const std::vector<TextEdit>& changes) override {
    const ProgramPoint& point = program_.points[target.point];
    const std::string head = text_.substr(point.begin, open_of(point) - point.begin);
    const std::string in_move =
        new_position(point, changes, head.substr(std::min(head.find_first_of(":]"), head.size())));
    const size_t colon = text_.find(':', target.begin);
    if (colon >= target.end) return in_move;
    return in_move.substr(0, in_move.find_first_of(":]")) + text_.substr(colon, target.end - colon);
  }

  std::string placed(const std::string& text) override {
    std::string whole;
    for (const char c : text) whole += c == '\n' ? line_end(text_, 0) : std::string(1, c);
    return position("]", whole + ";" + line_end(text_, 0));
  }

  // Once the lines are numbered.
  void insert(const Move& move) override { inserted_.push_back(move); }

 private:
  // Positions at the end of /POS; then the lines anew.
  void finish() override {
    if (number_ > kMaxFanucPosition)
      throw InputError(fmt::format(
          "{}: with the inserted points it has a position P[{}], and a FANUC controller has none "
          "above P[{}]; split it into programs that one calls after the other, or take a larger "
          "tolerance between points",
          program_.texts[0].name, number_, kMaxFanucPosition));
    const size_t end = std::min(line_that_begins(masked_, "/END"), text_.size());
    replace(end, end, positions_);
    if (inserted_.empty()) return;
    number_lines();
    count_lines();
  }

  // A position of /POS in the move, P[4]: a new one, unless it is among them. `name`: behind its
  // number, `:"name"]`; `rest`: behind that.
  std::string position(const std::string& name, const std::string& rest) {
    const auto [known, is_new] = numbers_.try_emplace(name + rest, number_ + 1);
    if (is_new) positions_ += fmt::format("P[{}", ++number_) + name + rest;
    return fmt::format("P[{}]", known->second);
  }

  // Declares a position as another one is, but for its number, what stands behind that, `name`, and
  // these edits. Returns it as it stands in a move, without its name.
  std::string new_position(const ProgramPoint& as, std::vector<TextEdit> edits,
                           const std::string& name) {
    edits.push_back({0, as.begin, open_of(as), ""});
    return position(name, changed(as, edits) + ";" + line_end(text_, as.begin));
  }

  void number_lines() {
    size_t next = 0;
    for (const auto& [begin, width, number] : lines_of_moves(text_)) {
      const auto numbered = [written = number, digits = width](size_t inserted) {
        return fmt::format("{:>{}}", *written + static_cast<double>(inserted), digits);
      };
      for (; next < inserted_.size() && inserted_[next].at == begin; ++next)
        // From the number to the point, as in the line of the end.
        replace(begin, begin,
                (number ? numbered(next) : std::string()) + inserted_[next].head.substr(width) +
                    inserted_[next].rest);
      if (next > 0 && number) replace(begin, begin + width, numbered(next));
    }
  }

  void count_lines() {
    if (const FanucLineCount count = fanuc_line_count(text_, inserted_.size()); count.end > 0)
      replace(count.begin, count.end, count.text);
  }

  // Of the `{` of a declared position.
  size_t open_of(const ProgramPoint& point) const {
    return std::min(masked_.find('{', point.begin), point.end);
  }

  const std::string masked_;
  std::vector<Move> inserted_;
  double number_ = 0;                      // of the last position
  std::map<std::string, double> numbers_;  // of new ones, by their texts behind the number
  std::string positions_;                  // new ones
};

}  // namespace

std::unique_ptr<MoveWriter> fanuc_writer(const RobotProgram& program) {
  return std::make_unique<FanucWriter>(program);
}

void refuse_long_fanuc_program(const RobotProgram& program, size_t inserted) {
  const size_t lines = numbered_lines(program.texts[0].text);
  if (lines + inserted <= kMaxFanucLines) return;
  throw InputError(fmt::format(
      "{}: has {} lines{}, and a FANUC controller loads some {} of a program; split it into "
      "programs "
      "that one calls after the other (CALL), and correct each{}",
      program.texts[0].name, lines,
      inserted > 0 ? fmt::format(" and {} inserted ones", inserted) : "", kMaxFanucLines,
      inserted > 0 ? ", or take a larger tolerance between points" : ""));
}

void add_fanuc_remark(const std::string& remark, std::string& text) {
  const size_t first = line_that_begins(text, "/MN");
  size_t place = 0, width = 0;
  double number = 0;
  for (const Statement& line : lines_of(text, first)) {
    if (line.begin > first && text[line.begin] == '/') break;
    TextCursor cursor(text, line.begin, line.end);
    const auto value = cursor.take_number();
    const size_t behind = cursor.at();
    if (value && cursor.next() == ':') {
      number = *value;
      width = behind - line.begin;
    }
    if (value || width > 0) place = line.end + 1;
  }
  if (place == 0 || place > text.size()) return;
  text.insert(place, fmt::format("{:>{}}:  {} ;{}", number + 1, width, remark, line_end(text, 0)));
  if (const FanucLineCount count = fanuc_line_count(text, 1); count.end > 0)
    text.replace(count.begin, count.end - count.begin, count.text);
}

}  // namespace armtrue
