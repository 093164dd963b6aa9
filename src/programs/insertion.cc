#include "programs/insertion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "armtrue/text/input_error.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"
#include "programs/written_number.h"

namespace armtrue {
namespace {

// What a FANUC controller loads: some 32,000 lines a program, and positions whose number fits into
// 16 bits.
constexpr size_t kMaxFanucLines = 32000;
constexpr double kMaxFanucPosition = 32766;

// The number of a line of /MN: `  12:L P[3] ..`.
struct LineNumber {
  size_t begin = 0, end = 0;  // of the line, with the blanks before it, and behind the number
  std::optional<double> value;
};

LineNumber line_number(std::string_view text, size_t begin, size_t end) {
  TextCursor cursor(text, begin, end);
  const auto value = cursor.take_number();
  const size_t behind = cursor.at();
  if (!value || cursor.next() != ':') return {begin, begin, std::nullopt};
  return {begin, behind, value};
}

// The lines of /MN.
std::vector<std::pair<size_t, size_t>> lines_of_moves(const std::string& text) {
  std::vector<std::pair<size_t, size_t>> lines;
  const size_t first = line_that_begins(text, "/MN");
  const size_t last = std::min(line_that_begins(text, "/POS"), line_that_begins(text, "/END"));
  for (size_t at = std::min(text.find('\n', first), text.size());
       at + 1 < std::min(last, text.size());) {
    const size_t end = std::min(text.find('\n', at + 1), text.size());
    lines.emplace_back(at + 1, end);
    at = end;
  }
  return lines;
}

size_t count_of_lines(const std::string& text) {
  return static_cast<size_t>(std::ranges::count_if(lines_of_moves(text), [&](const auto& line) {
    return line_number(text, line.first, line.second).value.has_value();
  }));
}

double largest_position(const std::string& text) {
  double largest = 0;
  for (size_t at = text.find("P["); at != std::string::npos; at = text.find("P[", at + 1)) {
    TextCursor cursor(text, at + 2, text.size());
    if (const auto number = cursor.take_number()) largest = std::max(largest, *number);
  }
  return largest;
}

class Inserter {
 public:
  Inserter(const RobotProgram& program, const std::vector<ProgramPointBetween>& between)
      : program_(program), between_(between), text_(program.texts[0].text) {}

  std::vector<TextEdit> edits(const std::vector<std::vector<TextEdit>>& changes,
                              const std::vector<OwnPoint>& own) {
    if (between_.empty() && own.empty()) return {};
    number_ = largest_position(text_);
    for (const OwnPoint& point : own) {
      const ProgramTarget& target = program_.targets[point.target];
      add(target.begin, target.end,
          point.text.empty() ? own_point(target, point.changes) : placed(point.text));
    }
    std::string via;
    for (size_t i = 0; i < between_.size(); ++i) {
      const ProgramPointBetween& point = between_[i];
      const ProgramTarget& target = program_.targets[point.target];
      if (point.is_left_out) {
        const ProgramTarget& end = program_.targets[point.target + 1];
        add(end.insertion.at, end.begin, end.insertion.before_line);
        continue;
      }
      const std::string text = written(point.target, changes[i]);
      if (point.motion == MotionKind::via) {
        if (i + 1 < between_.size() && between_[i + 1].target == point.target + 1)
          via = text + program_.targets[point.target + 1].insertion.middle;
        else
          add(target.begin, target.end, text);
        continue;
      }
      const ProgramInsertion& beside = target.insertion;
      const bool is_piece = point.motion == MotionKind::line && target.motion == MotionKind::arc;
      insert({beside.at, is_piece ? beside.before_line : beside.before,
              via + text + beside.behind + ending(point) + beside.line_end});
      via.clear();
    }
    if (program_.dialect == Dialect::fanuc) finish_fanuc();
    return std::move(edits_);
  }

 private:
  // A move before a place: its text before the point, and from the point on.
  struct Move {
    size_t at;
    std::string head, rest;
  };

  void insert(const Move& move) {
    if (program_.dialect == Dialect::fanuc)
      inserted_.push_back(move);  // once the lines are numbered
    else
      add(move.at, move.at, move.head + move.rest);
  }
  void add(size_t begin, size_t end, const std::string& text) {
    edits_.push_back({0, begin, end, text});
  }

  // The point of a target with other numbers, as it stands in a move.
  std::string written(size_t target, const std::vector<TextEdit>& changes) {
    const ProgramPoint& point = program_.points[program_.targets[target].point];
    return program_.dialect == Dialect::fanuc ? new_position(point, changes, "]")
                                              : on_one_line(changed(point, changes));
  }

  // The same in the move of the target: of FANUC with the name that it has there.
  std::string own_point(const ProgramTarget& target, const std::vector<TextEdit>& changes) {
    const ProgramPoint& point = program_.points[target.point];
    if (program_.dialect != Dialect::fanuc) return on_one_line(changed(point, changes));
    const std::string head = text_.substr(point.begin, point.declaration.open - point.begin);
    const std::string in_move =
        new_position(point, changes, head.substr(std::min(head.find_first_of(":]"), head.size())));
    const size_t colon = text_.find(':', target.begin);
    if (colon >= target.end) return in_move;
    return in_move.substr(0, in_move.find_first_of(":]")) + text_.substr(colon, target.end - colon);
  }

  // The text of a declared point after the edits of its numbers.
  std::string changed(const ProgramPoint& point, std::vector<TextEdit> edits) const {
    for (TextEdit& edit : edits) {
      edit.begin -= point.begin;
      edit.end -= point.begin;
    }
    const std::string& text = program_.texts[point.text].text;
    return apply_edits(text.substr(point.begin, point.end - point.begin), edits, point.text);
  }

  // Without comments.
  std::string on_one_line(std::string point) const {
    if (program_.dialect == Dialect::rapid) point = masked(point, '!', "");
    if (program_.dialect == Dialect::urscript) point = masked(point, '#', "");
    std::ranges::replace_if(
        point, [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return point;
  }

  // A point that is written out: in the move, or of FANUC as a position, with its name in the move.
  std::string placed(const std::string& text) {
    if (program_.dialect != Dialect::fanuc) return on_one_line(text);
    std::string whole;
    for (const char c : text) whole += c == '\n' ? line_end(text_, 0) : std::string(1, c);
    return position("]", whole + ";" + line_end(text_, 0));
  }

  // A position of /POS in the move, P[4]: a new one, unless it is among them. `name`: behind its
  // number, `:"name"]`; `rest`: behind that.
  std::string position(const std::string& name, const std::string& rest) {
    const auto [known, is_new] = numbers_.try_emplace(name + rest, number_ + 1);
    if (is_new) positions_ += fmt::format("P[{}", ++number_) + name + rest;
    return fmt::format("P[{}]", known->second);
  }

  std::string ending(const ProgramPointBetween& point) const {
    if (program_.dialect != Dialect::urscript) return "";
    constexpr int kDecimals = 5;
    return rounded_text(point.blend, 1, kDecimals) + ")";
  }

  // Positions at the end of /POS; then the lines anew.
  void finish_fanuc() {
    if (number_ > kMaxFanucPosition)
      throw InputError(fmt::format(
          "{}: with the inserted points it has a position P[{}], and a FANUC controller has none "
          "above P[{}]; split it into programs that one calls after the other, or take a larger "
          "tolerance between points",
          program_.texts[0].name, number_, kMaxFanucPosition));
    const size_t end = program_.declarations_end;
    add(end, end, positions_);
    if (inserted_.empty()) return;
    number_lines();
    count_lines();
  }

  // Declares a position as another one is, but for its number, what stands behind that, `name`, and
  // these edits. Returns it as it stands in a move, without its name.
  std::string new_position(const ProgramPoint& as, std::vector<TextEdit> edits,
                           const std::string& name) {
    edits.push_back({0, as.begin, as.declaration.open, ""});
    return position(name, changed(as, edits) + ";" + line_end(text_, as.begin));
  }

  void number_lines() {
    size_t next = 0;
    for (const auto& [begin, end] : lines_of_moves(text_)) {
      const LineNumber written = line_number(text_, begin, end);
      const auto numbered = [&](size_t inserted) {
        return fmt::format("{:>{}}", *written.value + static_cast<double>(inserted),
                           written.end - written.begin);
      };
      for (; next < inserted_.size() && inserted_[next].at == begin; ++next)
        // From the number to the point, as in the line of the end.
        add(begin, begin,
            (written.value ? numbered(next) : std::string()) +
                inserted_[next].head.substr(written.end - written.begin) + inserted_[next].rest);
      if (next > 0 && written.value) add(begin, written.end, numbered(next));
    }
  }

  // LINE_COUNT = 3;
  void count_lines() {
    const size_t attributes = line_that_begins(text_, "/ATTR");
    const size_t at = text_.find("LINE_COUNT", attributes);
    if (attributes == std::string::npos || at == std::string::npos) return;
    TextCursor cursor(text_, at + 10, std::min(text_.find('\n', at), text_.size()));
    if (!cursor.take('=')) return;
    cursor.next();
    const size_t begin = cursor.at();
    if (const auto count = cursor.take_number())
      add(begin, cursor.at(), fmt::format("{}", *count + static_cast<double>(inserted_.size())));
  }

  const RobotProgram& program_;
  const std::vector<ProgramPointBetween>& between_;
  const std::string& text_;
  std::vector<Move> inserted_;  // of FANUC
  double number_ = 0;           // of the last position
  std::map<std::string, double> numbers_;  // of new ones, by their texts behind the number
  std::string positions_;       // new ones
  std::vector<TextEdit> edits_;
};

}  // namespace

int decimals_kept(Dialect dialect, TargetKind kind, size_t component) {
  switch (dialect) {
    case Dialect::krl:
      return 4;           // KSS shows four
    case Dialect::rapid:  // num is a float: 1e-4 mm of a metre, 1e-5 deg of 180
      if (kind == TargetKind::joints) return 5;
      return component < 3 ? 4 : 7;
    case Dialect::fanuc:
      return 3;  // an LS file has three
    case Dialect::urscript:
      break;
  }
  return 7;
}

NumberCheck number_check(Dialect dialect, TargetKind kind, size_t component) {
  // A micrometre and a thousandth of a degree, which turns the tool about its tip, or a microradian.
  // The same of a joint moves the tool too far.
  constexpr int kOfMillimetre = 3, kOfMetre = 6;
  int rounded = dialect == Dialect::urscript ? kOfMetre : kOfMillimetre;
  const bool is_quaternion = dialect == Dialect::rapid && component >= 3;
  if (kind == TargetKind::joints || is_quaternion) rounded = 0;
  if (dialect == Dialect::fanuc) return {0, rounded};  // an LS file has no more decimals
  return {decimals_kept(dialect, kind, component) + 2, rounded};
}

double moved_by_check(Dialect dialect, TargetKind kind, size_t component) {
  const NumberCheck check = number_check(dialect, kind, component);
  double moved = 0;
  if (check.decimals > 0) moved += std::pow(10.0, -decimals_kept(dialect, kind, component));
  if (check.rounded > 0) moved += kMostMovedIfRounded * std::pow(10.0, -check.rounded);
  return moved;
}

int moves_of(const std::vector<ProgramPointBetween>& between) {
  return static_cast<int>(std::ranges::count_if(
      between, [](const auto& point) { return point.motion != MotionKind::via; }));
}

std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between,
                                      const std::vector<std::vector<TextEdit>>& changes,
                                      const std::vector<OwnPoint>& own) {
  return Inserter(program, between).edits(changes, own);
}

void refuse_what_does_not_load(const RobotProgram& program, size_t inserted) {
  if (program.dialect != Dialect::fanuc) return;
  const size_t lines = count_of_lines(program.texts[0].text);
  if (lines + inserted <= kMaxFanucLines) return;
  throw InputError(fmt::format(
      "{}: has {} lines{}, and a FANUC controller loads some {} of a program; split it into "
      "programs "
      "that one calls after the other (CALL), and correct each{}",
      program.texts[0].name, lines,
      inserted > 0 ? fmt::format(" and {} inserted ones", inserted) : "", kMaxFanucLines,
      inserted > 0 ? ", or take a larger tolerance between points" : ""));
}

}  // namespace armtrue
