#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "armtrue/kinematics/units.h"
#include "programs/dialects.h"
#include "programs/frame_list.h"
#include "programs/program_values.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"

// Teach pendant programs of FANUC controllers as LS files: R-30iB operator's manual, "Motion
// instructions" and "Position data": /PROG, /MN with J, L, C and A moves, /POS.

namespace armtrue {
namespace {

struct FanucPosition {
  std::map<std::string, ProgramNumber> numbers;  // X .. R, J1 .. J6, of group 1
  std::optional<int> frame, tool;
  std::string configuration;  // N U T, 0, 0, 0
  bool is_changed = false;    // P[1]=LPOS
  int line = 0;
  int point = -1;
};

constexpr const char* kFanucPose[] = {"X", "Y", "Z", "W", "P", "R"};
constexpr const char* kFanucJoints[] = {"J1", "J2", "J3", "J4", "J5", "J6"};

// 'N U T, 0, 0, 0': N or F: the wrist not flipped or flipped; U or D: the elbow up or down; T or B:
// the wrist before or behind axis 1; L or R is of arms that have it. Then the turns of J4, J5, J6.
// At J = (0, 0, 0, 0, -90, 0), the tool downwards, the string is N U T.
Configuration fanuc_configuration(const std::string& text) {
  Configuration result;
  result.reference << 0, 0, 0, 0, -90, 0;
  result.reference *= kDegree;
  const size_t comma = std::min(text.find(','), text.size());
  for (char c : upper(text.substr(0, comma))) {
    if (c == 'N' || c == 'F') result.sides[2] = c == 'N' ? 1 : -1;
    if (c == 'U' || c == 'D') result.sides[1] = c == 'U' ? 1 : -1;
    if (c == 'T' || c == 'B') result.sides[0] = c == 'T' ? 1 : -1;
  }
  TextCursor cursor(text, comma, text.size());
  for (int joint = 3; joint < kProgramAxes && cursor.take(','); ++joint) {
    const auto turn = cursor.take_number();
    constexpr double kMost = 8;
    if (!turn || std::abs(*turn) > kMost) break;
    result.low[joint] = (360 * *turn - 180) * kDegree;
    result.high[joint] = (360 * *turn + 180) * kDegree;
  }
  return result;
}

class FanucReader {
 public:
  FanucReader(RobotProgram& program, const KnownFrames& known)
      : program_(program),
        known_(known),
        original_(program.texts[0].text),
        text_(masked(original_, '\0', "\"'")),
        warnings_(program.texts[0].name) {}

  void read() {
    find_name();
    const size_t moves = section("/MN"), positions = section("/POS");
    const size_t end = std::min(section("/END"), text_.size());
    if (positions < end) read_positions(positions, end);
    if (moves < text_.size()) read_moves(moves, std::min(positions, end));
    program_.warnings = warnings_.list();
  }

 private:
  // Where the line begins that begins with a word; npos if there is none.
  size_t section(const std::string& word) const {
    for (size_t at = text_.find(word); at != std::string::npos; at = text_.find(word, at + 1))
      if (at == 0 || text_[at - 1] == '\n') return at;
    return std::string::npos;
  }

  void find_name() {
    const size_t prog = section("/PROG");
    if (prog == std::string::npos) return;
    TextCursor cursor(text_, prog + 5, std::min(text_.find('\n', prog), text_.size()));
    cursor.next();
    const size_t begin = cursor.at();
    if (!cursor.take_name().empty()) program_.names.push_back({0, begin, cursor.at()});
  }

  int line_of(size_t at) const {
    return 1 +
           static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<long>(at), '\n'));
  }

  // P[1:"name"]{ GP1: UF : 1, UT : 1, CONFIG : '..', X = 1.0 mm, .. };
  void read_positions(size_t begin, size_t end) {
    std::string part = text_.substr(0, end);
    part.replace(0, begin, begin, ' ');
    int line = line_of(begin) - 1;
    for (Statement statement : split_statements(part, ';')) {
      TextCursor cursor(part, statement.begin, statement.end);
      cursor.take('/');
      while (!cursor.done() && !(cursor.next() == 'P' || cursor.next() == 'p')) cursor.step();
      std::string word = cursor.take_name();
      if (word == "POS") word = cursor.take_name();
      if (word != "P" || !cursor.take('[')) continue;
      const auto number = cursor.take_number();
      cursor.skip_to("{");
      if (!number || !cursor.take('{')) continue;
      FanucPosition& position = positions_[*number];
      if (!position.numbers.empty()) position.is_changed = true;  // given twice
      position.line = line + statement.line;
      read_groups(cursor, position);
    }
  }

  void read_groups(TextCursor& cursor, FanucPosition& position) const {
    bool is_first = true;
    while (!cursor.done()) {
      const std::string name = cursor.take_name();
      if (name.empty()) {
        cursor.step();
      } else if (name.starts_with("GP") && cursor.take(':')) {
        is_first = name == "GP1";
      } else if (is_first) {
        read_entry(name, cursor, position);
      }
    }
  }

  void read_entry(const std::string& name, TextCursor& cursor, FanucPosition& position) const {
    if (cursor.take('=')) {
      cursor.next();
      const size_t begin = cursor.at();
      if (const auto value = cursor.take_number())
        position.numbers.try_emplace(name, ProgramNumber{0, begin, cursor.at(), *value, ""});
      cursor.take_name();  // mm, deg
      return;
    }
    if (!cursor.take(':')) return;
    if (name == "CONFIG" && cursor.take('\'')) {
      const size_t begin = cursor.at();
      cursor.skip_to("'");
      position.configuration = original_.substr(begin, cursor.at() - begin);
    } else if (name == "UF" || name == "UT") {
      if (const auto value = cursor.take_number(); value && std::abs(*value) < 1000)
        (name == "UF" ? position.frame : position.tool) = static_cast<int>(*value);
    }
  }

  void read_moves(size_t begin, size_t end) {
    std::string part = text_.substr(0, std::min(end, text_.size()));
    part.replace(0, begin, begin, ' ');
    const std::vector<Statement> statements = lines_of(part, begin);
    for (const Statement& statement : statements) read_statement(part, statement, true);
    for (const Statement& statement : statements) read_statement(part, statement, false);
  }

  // One for each line; a line that begins with a colon continues the one before. A comment may hold
  // quotes and semicolons.
  std::vector<Statement> lines_of(std::string& part, size_t begin) const {
    std::vector<Statement> lines;
    int line = line_of(begin);
    for (size_t at = begin; at < part.size(); ++line) {
      const size_t end = std::min(part.find('\n', at), part.size());
      TextCursor cursor(part, at, end);
      if (cursor.next() == ':' && !lines.empty()) {
        std::replace(part.begin() + static_cast<long>(lines.back().end),
                     part.begin() + static_cast<long>(at), '\n', ' ');
        lines.back().end = end;
      } else {
        lines.push_back({line, at, end});
      }
      at = end + 1;
    }
    return lines;
  }

  // `12:L P[3] 250mm/sec FINE`; a comment begins with ! or //.
  void read_statement(const std::string& part, const Statement& statement, bool assignments) {
    TextCursor cursor(part, statement.begin, statement.end);
    cursor.take_number();
    cursor.take(':');
    if (cursor.next() == '!' || cursor.next() == '/') return;
    const size_t begin = cursor.at();
    const std::string word = cursor.take_name();
    if (assignments) {
      if (word != "P" || !cursor.take('[')) return;
      const auto number = cursor.take_number();
      cursor.skip_to("=");
      if (cursor.take('=') && number) positions_[*number].is_changed = true;
      return;
    }
    const bool is_move = word == "J" || word == "L" || word == "C" || word == "A" || word == "S";
    if (!is_move || cursor.done()) return;
    read_move(part, {statement.line, begin, statement.end}, word);
  }

  void leave(int line, const std::string& reason) {
    warnings_.add(line, "left alone: " + reason);
    ++program_.left_alone;
  }

  void read_move(const std::string& part, const Statement& statement, const std::string& kind) {
    std::vector<double> ids;
    std::string other;
    TextCursor cursor(part, statement.begin, statement.end);
    while (!cursor.done()) {
      const std::string word = cursor.take_name();
      if (word.empty()) {
        cursor.step();
        continue;
      }
      if (word == "INC") other = "a relative move (INC)";
      if (word == "OFFSET" || word == "TOOL_OFFSET" || word == "VOFFSET" || word == "COORD")
        other = "the move is displaced (" + word + ")";
      if ((word == "P" || word == "PR") && cursor.take('[')) {
        const auto id = cursor.take_number();
        if (word == "P" && id)
          ids.push_back(*id);
        else if (ids.size() < 2)
          other = word == "PR" ? "its point is a register" : "its point has no plain number";
        cursor.skip_to("]");
      }
    }
    if (ids.empty() && other.empty()) return;  // no move: a word of the same letter
    if (!other.empty()) return leave(statement.line, other);
    if (ids.size() != (kind == "C" ? 2u : 1u))
      return leave(statement.line, "it does not have the points of its kind");
    for (double id : ids)
      if (!is_usable(id, statement.line)) return;
    for (size_t i = 0; i < ids.size(); ++i) add_target(ids[i], statement.line, i + 1 < ids.size());
  }

  bool is_usable(double id, int line) {
    const auto found = positions_.find(id);
    if (found == positions_.end() || (found->second.numbers.empty() && !found->second.is_changed)) {
      leave(line, "its point has no numbers in /POS");
      return false;
    }
    FanucPosition& position = found->second;
    if (position.is_changed) {
      leave(line, "its point is given several values, or changed at run time");
      return false;
    }
    if (position.point < 0) add_point(id, position);
    if (position.point < 0) leave(line, "its point has no plain numbers");
    return position.point >= 0;
  }

  void add_point(double id, FanucPosition& position) {
    ProgramPoint point;
    point.name = fmt::format("P[{}]", id);
    point.line = position.line;
    const bool is_joints = position.numbers.contains("J1");
    point.kind = is_joints ? TargetKind::joints : TargetKind::cartesian;
    for (int i = 0; i < 6; ++i) {
      const auto number = position.numbers.find(is_joints ? kFanucJoints[i] : kFanucPose[i]);
      if (number == position.numbers.end()) return;
      point.numbers.push_back(number->second);
    }
    position.point = static_cast<int>(program_.points.size());
    program_.points.push_back(point);
  }

  void add_target(double id, int line, bool is_auxiliary) {
    const FanucPosition& position = positions_[id];
    const ProgramPoint& point = program_.points[static_cast<size_t>(position.point)];
    std::vector<double> numbers;
    for (const ProgramNumber& number : point.numbers) numbers.push_back(number.value);
    ProgramTarget target;
    target.line = line;
    target.point = position.point;
    target.kind = point.kind;
    const auto frame = [&](const char* name, int number) {
      return add_frame(program_.frames, known_, fmt::format("{}[{}]", name, number),
                       number == 0 ? std::optional(Pose{}) : std::nullopt);
    };
    if (position.frame) target.base = frame("UF", *position.frame);
    if (position.tool) target.tool = frame("UT", *position.tool);
    if (point.kind == TargetKind::joints) {
      target.q = joints_of_numbers(Dialect::fanuc, numbers);
    } else {
      target.pose = pose_of_numbers(Dialect::fanuc, numbers);
      target.configuration = fanuc_configuration(position.configuration);
      target.configuration.continues = is_auxiliary;
    }
    program_.targets.push_back(target);
  }

  RobotProgram& program_;
  const KnownFrames& known_;
  const std::string original_;
  std::string text_;
  ProgramWarnings warnings_;
  std::map<double, FanucPosition> positions_;
};

}  // namespace

void parse_fanuc_program(RobotProgram& program, const KnownFrames& known) {
  FanucReader(program, known).read();
}

}  // namespace armtrue
