#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "programs/dialects.h"
#include "programs/frame_list.h"
#include "programs/program_values.h"
#include "programs/program_warnings.h"
#include "programs/rapid_insertion.h"
#include "programs/rapid_values.h"
#include "programs/rapid_words.h"
#include "programs/statement.h"

// Programs of ABB controllers: RAPID reference manual, "Instructions, functions and data types":
// robtarget, jointtarget, confdata, tooldata, wobjdata, MoveJ, MoveL, MoveC, MoveAbsJ and those of
// their family, TriggJ, TriggL, TriggC.

namespace armtrue {
namespace {

struct RapidValue {
  ListItem list;
  int values = 0;  // how often the name is given one
  int line = 0;
  std::string type;
  int point = -1;
};

class RapidReader {
 public:
  RapidReader(RobotProgram& program, const KnownFrames& known)
      : program_(program),
        known_(known),
        text_(masked(program.texts[0].text, '!', "\"")),
        warnings_(program.texts[0].name) {}

  void read() {
    const std::vector<Statement> statements = split_statements(text_, ';');
    for (const Statement& statement : statements) read_words(statement, true);
    for (const Statement& statement : statements) {
      is_move_ = false;
      read_words(statement, false);
      if (!is_move_) follows_ = follows_ && stays(statement);
    }
    for (const auto& [name, line] : uses_)
      if (values_[name].point >= 0)
        warnings_.add(line, "uses " + name + ", which is corrected, beside the moves to it");
      else
        leave(line, "uses the point " + name + " in a way that is not followed");
    program_.warnings = warnings_.list();
  }

 private:
  // Whether the arm stays where it is during a statement without a move, and the next one follows.
  bool stays(const Statement& statement) const {
    TextCursor cursor(text_, statement.begin, statement.end);
    return stands_between_rapid_moves(cursor.take_name()) ||
           is_plain_assignment(text_, statement.begin, statement.end);
  }

  // IF .. Move..; without THEN.
  bool is_conditional(size_t begin, size_t end) const {
    bool found = false;
    for (TextCursor cursor(text_, begin, end); !cursor.done();) {
      const std::string word = cursor.take_name();
      if (word.empty()) cursor.step();
      if (word == "IF" || word == "THEN") found = word == "IF";
    }
    return found;
  }

  int line_of(size_t at) {
    for (; counted_ < at; ++counted_) line_ += program_.texts[0].text[counted_] == '\n';
    if (counted_ > at) {
      counted_ = 0;
      line_ = 1;
      return line_of(at);
    }
    return line_;
  }

  // Goes through the words of a statement: what ends without a semicolon (PROC, IF .. THEN) stands
  // before it.
  void read_words(const Statement& statement, bool declarations) {
    TextCursor cursor(text_, statement.begin, statement.end);
    char before = ' ';
    while (!cursor.done()) {
      const size_t at = cursor.at();
      const std::string word = cursor.take_name();
      if (word.empty()) {
        before = cursor.next();
        cursor.step();
        continue;
      }
      if (word == "CONST" || word == "PERS" || word == "VAR") {
        if (is_parameter(cursor)) continue;
        if (declarations) read_declaration(cursor);
        return;
      }
      if (before != '\\' && before != '.' && !declarations &&
          read_instruction(word, at, cursor, statement))
        return;
      if (declarations && before != '\\' && before != '.') note_assignment(word, cursor);
      if (!declarations && cursor.next() != ':' && cursor.next() != '.') note_use(word, at);
      before = ' ';
    }
  }

  // PROC name(PERS robtarget point)
  static bool is_parameter(TextCursor cursor) {
    cursor.take_name();
    cursor.take_name();
    return cursor.next() == ')' || cursor.next() == ',';
  }

  void note_use(const std::string& word, size_t at) {
    if (const auto found = values_.find(word); found != values_.end() && is_point(found->second))
      uses_.try_emplace(word, line_of(at));
  }

  static bool is_point(const RapidValue& value) {
    return value.type == "ROBTARGET" || value.type == "JOINTTARGET";
  }

  // NAME := .., NAME.trans.x := .., NAME{2} := ..
  void note_assignment(const std::string& word, TextCursor cursor) {
    while (true) {
      if (cursor.take('.'))
        cursor.take_name();
      else if (cursor.take('{'))
        cursor.skip_to("}"), cursor.take('}');
      else
        break;
    }
    if (cursor.take(':') && cursor.take('=')) ++values_[word].values;
  }

  // type NAME := [..]  or  type NAME{3} := [[..],[..],[..]]
  void read_declaration(TextCursor& cursor) {
    const std::string type = cursor.take_name(), name = cursor.take_name();
    if (name.empty()) return;
    const bool is_array = cursor.take('{');
    if (is_array) {
      cursor.skip_to("}");
      cursor.take('}');
    }
    const int line = line_of(cursor.at());
    if (!cursor.take(':') || !cursor.take('=')) {
      values_[name].type = type;
      return;
    }
    const ListItem list = take_item(cursor);
    if (list.kind != ListItem::Kind::list || !cursor.done()) {
      values_[name].type = type;
      ++values_[name].values;
      return;
    }
    const auto define = [&](const std::string& full, const ListItem& value) {
      RapidValue& known = values_[full];
      known.list = value;
      known.type = type;
      known.line = line;
      ++known.values;
    };
    define(name, list);
    for (size_t i = 0; is_array && i < list.items.size(); ++i)
      define(fmt::format("{}{{{}}}", name, i + 1), list.items[i]);
  }

  bool read_instruction(const std::string& word, size_t at, TextCursor& cursor,
                        const Statement& statement) {
    if (word == "PDISPON" || word == "PDISPSET" || word == "PDISPOFF") {
      is_displaced_ = word != "PDISPOFF";
      return true;
    }
    if (word == "CIRPATHMODE") turning_ = rapid_turning(cursor);
    if (const RapidMove* const move = find_rapid_move(word)) {
      if (cursor.next() == '(' || cursor.next() == ':') return false;
      is_move_ = true;
      move_ = {move, at, statement.end, statement.begin == at, {}, {}};
      const int left_alone = program_.left_alone;
      read_move(*move, line_of(at), cursor.at(), statement.end);
      follows_ = program_.left_alone == left_alone && !is_conditional(statement.begin, at);
      return true;
    }
    if (!is_other_rapid_move(word) || cursor.done() || cursor.next() == '(' || cursor.next() == ':')
      return false;
    leave(line_of(at), "this instruction is not followed: " + word);
    is_move_ = true;
    follows_ = false;
    return true;
  }

  void leave(int line, const std::string& reason) {
    warnings_.add(line, "left alone: " + reason);
    ++program_.left_alone;
  }

  void read_move(const RapidMove& move, int line, size_t begin, size_t end) {
    std::vector<Statement> arguments;
    std::string work_object = "WOBJ0";
    move_.parts.clear();
    move_.options.clear();
    for (const Statement& part : split_arguments(text_, begin, end, ",")) {
      const std::vector<Statement> pieces = split_arguments(text_, part.begin, part.end, "\\");
      for (size_t i = 0; i < pieces.size(); ++i) {
        const bool is_option = i > 0;
        if (!is_option && pieces[i].begin < pieces[i].end) {
          arguments.push_back(pieces[i]);
          move_.parts.push_back(part);
        }
        if (!is_option) continue;
        TextCursor cursor(text_, pieces[i].begin, pieces[i].end);
        move_.options.push_back(cursor.take_name());
        if (move_.options.back() == "WOBJ" && cursor.take(':') && cursor.take('=')) {
          cursor.next();
          work_object = upper(part_of(cursor.at(), pieces[i].end));
        }
      }
    }
    if (arguments.size() <= static_cast<size_t>(move.tool))
      return leave(line, "its arguments are not those of the instruction");
    if (is_displaced_) return leave(line, "a program displacement (PDispOn, PDispSet) is active");
    const Statement& tool = arguments[static_cast<size_t>(move.tool)];
    ProgramTarget target;
    target.line = line;
    target.kind = move.is_joint_target ? TargetKind::joints : TargetKind::cartesian;
    std::string why_not;
    target.base = work_object_frame(work_object, why_not);
    target.tool = tool_frame(upper(part_of(tool.begin, tool.end)), why_not);
    if (!why_not.empty()) return leave(line, why_not);
    std::vector<int> points;
    for (int i = 0; i < move.points; ++i) {
      points.push_back(point_at(arguments[static_cast<size_t>(i)], target.kind, line));
      if (points.back() < 0) return;
    }
    const char kind = move_.kind();
    const auto zone = static_cast<size_t>(move.tool - 1);
    target.blend = radius_of_zone(upper(part_of(arguments[zone].begin, arguments[zone].end)));
    for (size_t i = 0; i < points.size(); ++i) {
      const bool is_auxiliary = i + 1 < points.size();
      target.motion = kind == 'L'    ? MotionKind::line
                      : kind != 'C'  ? MotionKind::joint
                      : is_auxiliary ? MotionKind::via
                                     : MotionKind::arc;
      target.follows_target = i > 0 || (follows_ && move_.is_first);
      target.turning = turning_;
      target.begin = arguments[i].begin;
      target.end = arguments[i].end;
      if (kind == 'L' || target.motion == MotionKind::arc)
        prepare_rapid_insertion(program_, text_, move_, external_, points, arguments, target);
      add_target(target, points[i], is_auxiliary);
    }
  }

  void add_target(ProgramTarget target, int index, bool is_auxiliary) {
    const ProgramPoint& point = program_.points[static_cast<size_t>(index)];
    target.point = index;
    std::vector<double> numbers;
    for (const ProgramNumber& number : point.numbers) numbers.push_back(number.value);
    if (target.kind == TargetKind::joints) {
      target.q = joints_of_numbers(Dialect::rapid, numbers);
    } else {
      target.pose = pose_of_numbers(Dialect::rapid, numbers);
      target.configuration = rapid_configuration(point);
      target.configuration.continues = is_auxiliary;
    }
    program_.targets.push_back(target);
  }

  std::string part_of(size_t begin, size_t end) const { return text_.substr(begin, end - begin); }

  // The point of an argument; -1 and a warning if it cannot be followed.
  int point_at(const Statement& argument, TargetKind kind, int line) {
    const auto refuse = [&](const std::string& reason) {
      leave(line, reason);
      return -1;
    };
    if (const auto list = list_in(text_, argument.begin, argument.end)) {
      const int point = add_point(*list, kind, fmt::format("the point of line {}", line), line);
      return point < 0 ? refuse("its point has no plain numbers") : point;
    }
    std::string name;
    for (char c : part_of(argument.begin, argument.end))
      if (!is_blank(c)) name += c;
    const std::string key = upper(name), array = key.substr(0, key.find('{'));
    TextCursor cursor(key, 0, key.size());
    cursor.take_name();
    if (!cursor.done() && cursor.next() != '{')
      return refuse("its target is an expression; it starts from corrected points");
    const auto found = values_.find(key);
    if (found == values_.end())
      return refuse("its point is not declared here; give it plain numbers in this module");
    const auto whole = values_.find(array);
    if (found->second.values != 1 || (whole != values_.end() && whole->second.values != 1))
      return refuse("its point is given several values, or changed at run time");
    RapidValue& value = found->second;
    if (value.type != (kind == TargetKind::joints ? "JOINTTARGET" : "ROBTARGET"))
      return refuse("its point is of another type");
    if (value.point < 0) value.point = add_point(value.list, kind, name, value.line);
    return value.point < 0 ? refuse("its point has no plain numbers") : value.point;
  }

  int add_point(const ListItem& list, TargetKind kind, const std::string& name, int line) {
    ProgramPoint point;
    point.name = name;
    point.line = line;
    point.begin = list.begin;
    point.end = list.end;
    point.kind = kind;
    const auto add = [](std::vector<ProgramNumber>& numbers, const ListItem& from) {
      for (const ListItem& item : from.items)
        numbers.push_back({0, item.begin, item.end, item.value, ""});
    };
    const std::vector<ListItem>& parts = list.items;
    if (kind == TargetKind::joints) {
      if (parts.size() != 2 || !parts[0].numbers(6)) return -1;
      add(point.numbers, parts[0]);
      constexpr double kNoAxis = 1e8;  // 9E9
      for (const ProgramNumber& number : point.numbers)
        if (!(std::abs(number.value) < kNoAxis)) return -1;
    } else {
      if (parts.size() != 4 || !parts[0].numbers(3) || !parts[2].numbers(4)) return -1;
      if (!is_rapid_quaternion(parts[1])) return -1;
      add(point.numbers, parts[0]);
      add(point.numbers, parts[1]);
      add(point.configuration, parts[2]);
    }
    program_.points.push_back(point);
    const int index = static_cast<int>(program_.points.size()) - 1;
    if (const auto values = parts.back().numbers(6)) external_[index] = *values;
    return index;
  }

  const RapidValue* value_of(const std::string& name, const char* type) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.values != 1) return nullptr;
    const RapidValue& value = found->second;
    return value.type == type && value.list.kind == ListItem::Kind::list ? &value : nullptr;
  }

  std::string word_of(const ListItem& item) const { return upper(part_of(item.begin, item.end)); }
  // [robhold, ufprog, "ufmec", uframe, oframe]
  int work_object_frame(const std::string& name, std::string& why_not) {
    std::optional<Pose> pose;
    if (name == "WOBJ0") pose = Pose{};
    if (const RapidValue* value = value_of(name, "WOBJDATA");
        value && value->list.items.size() == 5) {
      const std::vector<ListItem>& parts = value->list.items;
      const auto user = rapid_pose(parts[3]), object = rapid_pose(parts[4]);
      if (user && object) pose = *user * *object;
      if (word_of(parts[0]) == "TRUE") why_not = "the robot holds the work object";
      if (word_of(parts[1]) == "FALSE") why_not = "a mechanical unit moves the work object";
    }
    return add_frame(program_.frames, known_, name, pose);
  }

  // [robhold, tframe, tload]
  int tool_frame(const std::string& name, std::string& why_not) {
    std::optional<Pose> pose;
    if (name == "TOOL0") pose = Pose{};
    if (const RapidValue* value = value_of(name, "TOOLDATA");
        value && value->list.items.size() == 3) {
      pose = rapid_pose(value->list.items[1]);
      if (word_of(value->list.items[0]) == "FALSE") why_not = "its tool stands in the room";
    }
    return add_frame(program_.frames, known_, name, pose);
  }

  RobotProgram& program_;
  const KnownFrames& known_;
  std::string text_;
  ProgramWarnings warnings_;
  RapidMoveText move_;    // that is read
  bool is_move_ = false;  // the statement moves the arm
  bool follows_ = false;  // the arm stands at the last target
  RapidExternalAxes external_;
  std::map<std::string, RapidValue> values_;
  std::map<std::string, int> uses_;  // of points outside of moves: the first line
  bool is_displaced_ = false;
  ArcTurning turning_ = ArcTurning::with_path;
  size_t counted_ = 0;
  int line_ = 1;
};

}  // namespace

void parse_rapid_program(RobotProgram& program, const KnownFrames& known) {
  RapidReader(program, known).read();
}

}  // namespace armtrue
