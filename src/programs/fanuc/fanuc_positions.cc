#include "programs/fanuc/fanuc_positions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "programs/statement.h"

namespace armtrue {
namespace {

class FanucPositionReader {
 public:
  FanucPositionReader(const std::string& original, const std::string& text)
      : original_(original), text_(text) {}

  // P[1:"name"]{ GP1: UF : 1, UT : 1, CONFIG : '..', X = 1.0 mm, .. };
  void read_all(size_t begin, size_t end) {
    std::string part = text_.substr(0, end);
    part.replace(0, begin, begin, ' ');
    const int line = line_at(text_, begin) - 1;
    for (Statement statement : split_statements(part, ';')) {
      TextCursor cursor(part, statement.begin, statement.end);
      cursor.take('/');
      while (!cursor.done() && !(cursor.next() == 'P' || cursor.next() == 'p')) cursor.step();
      size_t from = cursor.at();
      std::string word = cursor.take_name();
      if (word == "POS") {
        cursor.next();
        from = cursor.at();
        word = cursor.take_name();
      }
      if (word != "P" || !cursor.take('[')) continue;
      const auto number = cursor.take_number();
      cursor.skip_to("{");
      if (!number || !cursor.take('{')) continue;
      FanucPosition& position = positions_[*number];
      if (position.line > 0) position.is_changed = true;  // given twice
      position.line = line + statement.line;
      position.begin = from;
      position.end = statement.end;
      read_groups(cursor, position);
    }
  }

  std::map<double, FanucPosition> take() { return std::move(positions_); }

 private:
  void read_groups(TextCursor& cursor, FanucPosition& position) const {
    std::string group = "GP1";
    while (!cursor.done()) {
      const std::string name = cursor.take_name();
      if (name.empty()) {
        cursor.step();
      } else if (name.starts_with("GP") && cursor.take(':')) {
        group = name;
      } else if (group == "GP1") {
        read_entry(name, cursor, position);
      } else if (cursor.take('=')) {
        if (const auto value = cursor.take_number()) position.others[group + " " + name] = *value;
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
    if (cursor.take('\'')) {  // CONFIG; in other languages it has another name
      const size_t begin = cursor.at();
      cursor.skip_to("'");
      position.configuration_place = ProgramNumber{0, begin, cursor.at(), 0, ""};
      position.configuration = original_.substr(begin, cursor.at() - begin);
    } else if (name == "UF" || name == "UT") {
      const bool is_frame = name == "UF";
      if (const auto value = cursor.take_number(); value && std::abs(*value) < 1000)
        (is_frame ? position.frame : position.tool) = static_cast<int>(*value);
      else if (cursor.take_name() == "F")
        (is_frame ? position.is_in_active_frame : position.has_active_tool) = true;
    }
  }

  const std::string &original_, &text_;
  std::map<double, FanucPosition> positions_;
};

}  // namespace

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

std::map<double, FanucPosition> fanuc_positions(const std::string& original,
                                                const std::string& text, size_t begin, size_t end) {
  FanucPositionReader reader(original, text);
  reader.read_all(begin, end);
  return reader.take();
}

}  // namespace armtrue
