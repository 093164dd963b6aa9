#include "programs/insertion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "armtrue/text/input_error.h"
#include "programs/program_values.h"
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

  std::vector<TextEdit> edits() {
    if (between_.empty()) return {};
    double number = largest_position(text_);
    std::string positions, via;
    for (size_t i = 0; i < between_.size(); ++i) {
      const ProgramPointBetween& point = between_[i];
      const bool is_fanuc = program_.dialect == Dialect::fanuc;
      if (is_fanuc) positions += position_text(point, ++number);
      const std::string text = is_fanuc ? fmt::format("P[{}]", number) : text_of_point(point);
      const ProgramInsertion& beside = move_of(point).insertion;
      if (point.motion != MotionKind::via) {
        insert({beside.at, beside.before,
                via + text + beside.behind + ending(point) + beside.line_end});
        via.clear();
      } else if (i + 1 < between_.size() && between_[i + 1].target == point.target + 1) {
        via = text + beside.middle;
      } else {
        add(beside.via_begin, beside.via_end, text);
      }
    }
    if (program_.dialect == Dialect::fanuc) finish_fanuc(number, positions);
    return std::move(edits_);
  }

 private:
  // A move before a place: its text before the point, and from the point on.
  struct Move {
    size_t at;
    std::string head, rest;
  };

  const ProgramTarget& move_of(const ProgramPointBetween& point) const {
    return program_.targets[point.motion == MotionKind::via ? point.target + 1 : point.target];
  }
  const ProgramPoint& end_of(const ProgramPointBetween& point) const {
    return program_.points[static_cast<size_t>(program_.targets[point.target].point)];
  }
  void insert(const Move& move) {
    if (program_.dialect == Dialect::fanuc)
      inserted_.push_back(move);  // once the lines are numbered
    else
      add(move.at, move.at, move.head + move.rest);
  }
  void add(size_t begin, size_t end, const std::string& text) {
    edits_.push_back({0, begin, end, text});
  }

  // Numbers of the pose, rounded; of the angles that mean the same those next to the move's end.
  std::vector<std::string> numbers_of(const ProgramPointBetween& point) const {
    std::vector<double> written;
    for (const ProgramNumber& number : end_of(point).numbers) written.push_back(number.value);
    std::vector<std::string> texts;
    for (double value : numbers_of_pose(program_.dialect, point.pose, written)) {
      const int kept = decimals_kept(program_.dialect, TargetKind::cartesian, texts.size());
      texts.push_back(rounded_text(value, program_.dialect == Dialect::fanuc ? kept : 1, kept));
    }
    return texts;
  }

  std::string text_of_point(const ProgramPointBetween& point) const {
    const std::vector<std::string> n = numbers_of(point);
    if (program_.dialect == Dialect::krl)
      return fmt::format("{{X {},Y {},Z {},A {},B {},C {}}}", n[0], n[1], n[2], n[3], n[4], n[5]);
    if (program_.dialect == Dialect::urscript) return fmt::format("p[{}]", fmt::join(n, ","));
    std::array<double, 4> cf{};
    for (size_t i = 0; i < 4; ++i) cf[i] = end_of(point).configuration[i].value;
    if (point.q)
      for (size_t i = 0; i < 3; ++i) cf[i] = quadrant((*point.q)[i == 0 ? 0 : i == 1 ? 3 : 5]);
    return fmt::format("[[{},{},{}],[{},{},{},{}],[{},{},{},{}]{}", n[0], n[1], n[2], n[3], n[4],
                       n[5], n[6], cf[0], cf[1], cf[2], cf[3], move_of(point).insertion.point_end);
  }

  std::string ending(const ProgramPointBetween& point) const {
    if (program_.dialect != Dialect::urscript) return "";
    constexpr int kDecimals = 5;
    return rounded_text(point.blend, 1, kDecimals) + ")";
  }

  // Positions at the end of /POS, the last of which has this number; then the lines anew.
  void finish_fanuc(double number, const std::string& positions) {
    if (number > kMaxFanucPosition)
      throw InputError(fmt::format(
          "{}: with the inserted points it has a position P[{}], and a FANUC controller has none "
          "above P[{}]; split it into programs that one calls after the other, or take a larger "
          "tolerance between points",
          program_.texts[0].name, number, kMaxFanucPosition));
    const size_t end = program_.declarations_end;
    add(end, end, positions);
    number_lines();
    count_lines();
  }

  // The declaration of the move's end with another number and other values, without its name.
  std::string position_text(const ProgramPointBetween& point, double number) const {
    const ProgramPoint& end = end_of(point);
    const ProgramDeclaration& whole = end.declaration;
    std::vector<TextEdit> edits{{0, whole.begin, whole.open, fmt::format("P[{}]", number)}};
    if (whole.configuration_begin > 0)  // a position may have none
      edits.push_back(
          {0, whole.configuration_begin, whole.configuration_end, configuration_text(point)});
    const std::vector<std::string> texts = numbers_of(point);
    for (size_t i = 0; i < texts.size(); ++i)
      edits.push_back({0, end.numbers[i].begin, end.numbers[i].end, texts[i]});
    for (TextEdit& edit : edits) {
      edit.begin -= whole.begin;
      edit.end -= whole.begin;
    }
    return apply_edits(text_.substr(whole.begin, whole.end - whole.begin), edits, 0) + ";" +
           line_end(text_, whole.begin);
  }

  // N U T, 0, 0, 0: the letters of the end, the turns of the joints.
  std::string configuration_text(const ProgramPointBetween& point) const {
    const ProgramDeclaration& whole = end_of(point).declaration;
    const std::string text = text_.substr(whole.configuration_begin,
                                          whole.configuration_end - whole.configuration_begin);
    const size_t comma = text.find(',');
    if (comma == std::string::npos || !point.q) return text;
    const auto turn = [&](int joint) {
      return static_cast<int>(std::lround((*point.q)[joint] / (2 * std::numbers::pi)));
    };
    return fmt::format("{}, {}, {}, {}", text.substr(0, comma), turn(3), turn(4), turn(5));
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

int moves_of(const std::vector<ProgramPointBetween>& between) {
  return static_cast<int>(std::ranges::count_if(
      between, [](const auto& point) { return point.motion != MotionKind::via; }));
}

std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between) {
  return Inserter(program, between).edits();
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
