#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "programs/dialects.h"
#include "programs/frame_list.h"
#include "programs/program_values.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"

// Programs of Universal Robots: the URScript programming language, module motion: movej, movel,
// movep, movec, with poses p[x,y,z,rx,ry,rz] in m and rad and joints [..] in rad; get_inverse_kin,
// pose_trans, set_tcp.

namespace armtrue {
namespace {

bool is_other_motion(const std::string& word) {
  for (const char* name : {"SERVOJ", "SERVOC", "SERVOL", "SPEEDJ", "SPEEDL"})
    if (word == name) return true;
  return false;
}

// What an argument stands for: a literal, or a name that is given one.
struct UrValue {
  TargetKind kind = TargetKind::cartesian;
  std::string name;
  ListItem list;
  int line = 0;
  int base = -1;              // of pose_trans
  size_t begin = 0, end = 0;  // where the literal or the name stands in the call
  size_t open = 0;            // the bracket of the call
  std::optional<JointVector> near;
};

// Functions that leave the arm where it is.
bool stands_between_ur_moves(const std::string& word) {
  static const std::set<std::string> kWords{"SET_TCP",
                                            "SET_DIGITAL_OUT",
                                            "SET_STANDARD_DIGITAL_OUT",
                                            "SET_CONFIGURABLE_DIGITAL_OUT",
                                            "SET_ANALOG_OUT",
                                            "SET_TOOL_DIGITAL_OUT",
                                            "SET_STANDARD_ANALOG_OUT",
                                            "SET_PAYLOAD",
                                            "SET_PAYLOAD_COG",
                                            "SET_PAYLOAD_MASS",
                                            "SET_TARGET_PAYLOAD",
                                            "SET_GRAVITY",
                                            "SET_FLAG",
                                            "SLEEP",
                                            "SYNC",
                                            "TEXTMSG"};
  return kWords.contains(word);
}

struct UrVariable {
  std::optional<UrValue> literal;
  int values = 0;
  int point = -1;
};

class UrReader {
 public:
  UrReader(RobotProgram& program, const KnownFrames& known)
      : program_(program),
        known_(known),
        text_(masked(program.texts[0].text, '#', "\"'")),
        warnings_(program.texts[0].name) {}

  void read() {
    const std::vector<Statement> statements = split_statements(text_, '\n');
    for (const Statement& statement : statements) read_assignment(statement);
    for (const Statement& statement : statements) {
      is_move_ = false;
      read_calls(statement);
      if (!is_move_) follows_ = follows_ && stays(statement);
    }
    program_.warnings = warnings_.list();
  }

 private:
  // Whether the arm stays where it is during a statement without a move, and the next one follows.
  bool stays(const Statement& statement) const {
    TextCursor cursor(text_, statement.begin, statement.end);
    TextCursor assigned = cursor;
    const std::string word = cursor.take_name();
    if (word == "GLOBAL" || word == "LOCAL") assigned = cursor;
    return (stands_between_ur_moves(word) && cursor.next() == '(') ||
           is_plain_assignment(text_, assigned.at(), statement.end);
  }

  // [global|local] NAME = VALUE
  void read_assignment(const Statement& statement) {
    TextCursor cursor(text_, statement.begin, statement.end);
    std::string name = cursor.take_name();
    if (name == "GLOBAL" || name == "LOCAL") name = cursor.take_name();
    const bool is_element = cursor.take('[');
    if (is_element) cursor.skip_to("="), cursor.next();
    if (name.empty() || !cursor.take('=') || cursor.next() == '=') return;
    UrVariable& variable = variables_[name];
    variable.values += is_element ? 2 : 1;
    cursor.next();
    variable.literal = literal_in({statement.line, cursor.at(), statement.end});
    if (variable.literal) variable.literal->name = name;
  }

  // p[..] or [..]
  std::optional<UrValue> literal_in(const Statement& part) const {
    TextCursor cursor(text_, part.begin, part.end);
    UrValue value;
    value.line = part.line;
    value.kind = TargetKind::joints;
    if (cursor.next() == 'p' || cursor.next() == 'P') {
      if (cursor.take_name() != "P") return std::nullopt;
      value.kind = TargetKind::cartesian;
    }
    cursor.next();
    size_t end = part.end;
    while (end > cursor.at() && is_blank(text_[end - 1])) --end;
    if (end > cursor.at() && text_[end - 1] == ';') --end;
    const auto list = list_in(text_, cursor.at(), end);
    if (!list || !list->numbers(6)) return std::nullopt;
    value.list = *list;
    value.name = fmt::format("the point of line {}", part.line);
    return value;
  }

  void read_calls(const Statement& statement) {
    TextCursor cursor(text_, statement.begin, statement.end);
    std::string before;
    while (!cursor.done()) {
      const size_t begin = cursor.at();
      const std::string word = cursor.take_name();
      if (word.empty()) {
        cursor.step();
        before.clear();
        continue;
      }
      const bool is_call = cursor.next() == '(' && before != "DEF" && before != "THREAD";
      before = word;
      if (!is_call) continue;
      const size_t open = cursor.at();
      const size_t close = closing(open, statement.end);
      if (word == "SET_TCP") read_tool(statement.line, open, close);
      if (word == "MOVEJ" || word == "MOVEL" || word == "MOVEP" || word == "MOVEC") {
        const int left_alone = program_.left_alone;
        const bool is_first = begin == statement.begin;
        follows_ = follows_ && is_first;
        is_move_ = true;
        read_move(word, statement, open, close);
        follows_ = is_first && program_.left_alone == left_alone;
      }
      if (is_other_motion(word)) {
        leave(statement.line, "this function is not followed: " + word);
        is_move_ = true;
        follows_ = false;
      }
    }
  }

  size_t closing(size_t open, size_t end) const {
    int depth = 0;
    for (size_t i = open; i < end; ++i) {
      if (text_[i] == '(') ++depth;
      if (text_[i] == ')' && --depth == 0) return i;
    }
    return end;
  }

  void leave(int line, const std::string& reason) {
    warnings_.add(line, "left alone: " + reason);
    ++program_.left_alone;
  }

  std::string part_of(const Statement& part) const {
    return text_.substr(part.begin, part.end - part.begin);
  }

  void read_tool(int line, size_t open, size_t close) {
    const std::vector<Statement> arguments = arguments_in(line, open, close);
    std::optional<Pose> pose;
    std::string name = part_of(arguments[0]);
    if (const auto value = value_of(arguments[0]); value && value->kind == TargetKind::cartesian)
      pose = pose_of_numbers(Dialect::urscript, *value->list.numbers(6));
    tool_ = add_frame(program_.frames, known_, name, pose);
  }

  std::vector<Statement> arguments_in(int line, size_t open, size_t close) const {
    std::vector<Statement> arguments =
        split_arguments(text_, std::min(open + 1, close), close, ",");
    for (Statement& argument : arguments) argument.line = line;
    return arguments;
  }

  void read_move(const std::string& word, const Statement& statement, size_t open, size_t close) {
    const int line = statement.line;
    const std::vector<Statement> arguments = arguments_in(line, open, close);
    const size_t points = word == "MOVEC" ? 2 : 1;
    if (arguments.size() < points)
      return leave(line, "its arguments are not those of the function");
    std::vector<UrValue> values;
    for (size_t i = 0; i < points; ++i) {
      const auto value = value_of(arguments[i]);
      if (!value) return leave(line, why_not(arguments[i]));
      values.push_back(*value);
      values.back().open = open;
    }
    const Options options = options_of(arguments, points);
    for (size_t i = 0; i < points; ++i) {
      const bool is_last = i + 1 == points;
      add_target(values[i], line, word != "MOVEJ" || !is_last);
      ProgramTarget& target = program_.targets.back();
      target.motion = word == "MOVEJ"   ? MotionKind::joint
                      : word != "MOVEC" ? MotionKind::line
                      : is_last         ? MotionKind::arc
                                        : MotionKind::via;
      target.follows_target = i > 0 || follows_;
      target.blend = options.radius.value_or(0);
      if (target.motion == MotionKind::line)
        prepare_insertion(target, values[i], options, statement, close);
    }
  }

  // What stands behind the points of a move.
  struct Options {
    std::string kept;              // without time and radius
    std::optional<double> radius;  // 0 if none is given; nothing if it is an expression
    bool has_time = false;
  };

  // a, v, t, r in this order, or by name.
  Options options_of(const std::vector<Statement>& arguments, size_t points) const {
    Options options;
    options.radius = 0;
    for (size_t i = points; i < arguments.size(); ++i) {
      const Statement& argument = arguments[i];
      TextCursor cursor(text_, argument.begin, argument.end);
      std::string name = cursor.take_name();
      if (name.empty() || !cursor.take('=')) {
        cursor = TextCursor(text_, argument.begin, argument.end);
        const size_t place = i - points;
        name = place == 2 ? "T" : place == 3 ? "R" : "";
      }
      const auto value = cursor.take_number();
      const bool is_plain = value && cursor.done();
      if (name == "T")
        options.has_time |= !is_plain || *value != 0;
      else if (name == "R")
        options.radius = is_plain ? value : std::nullopt;
      else
        options.kept += ", " + part_of(argument);
    }
    return options;
  }

  void prepare_insertion(ProgramTarget& target, const UrValue& value, const Options& options,
                         const Statement& statement, size_t close) const {
    const std::string& original = program_.texts[0].text;
    const size_t line = line_begin(original, statement.begin);
    TextCursor behind(text_, std::min(close + 1, statement.end), statement.end);
    behind.take(';');
    if (target.kind == TargetKind::joints) target.obstacle = "its point is joint angles";
    if (options.has_time) target.obstacle = "its speed is a time (t)";
    if (!options.radius) target.obstacle = "its radius is no plain number";
    if (!behind.done() || !TextCursor(text_, line, statement.begin).done())
      target.obstacle = "it does not stand alone on its line";
    if (!target.obstacle.empty()) return;
    // A point may stand in pose_trans() or get_inverse_kin(): up to the end of the argument.
    const size_t first = arguments_in(statement.line, value.open, close)[0].end;
    target.insertion = {line, text_.substr(line, value.begin - line),
                        text_.substr(value.end, first - value.end) + options.kept + ", r=",
                        line_end(original, close), ""};
    for (std::string* text : {&target.insertion.before, &target.insertion.behind})
      std::ranges::replace(*text, '\r', ' ');
  }

  std::string why_not(const Statement& argument) const {
    TextCursor cursor(text_, argument.begin, argument.end);
    const auto found = variables_.find(cursor.take_name());
    if (found == variables_.end() || !cursor.done())
      return "its target is an expression or has no plain numbers";
    return found->second.values > 1 ? "its point is given several values"
                                    : "its point is calculated at run time";
  }

  // A literal, a name, get_inverse_kin(pose, qnear) or pose_trans(frame, pose).
  std::optional<UrValue> value_of(const Statement& argument, int depth = 0) {
    if (auto literal = literal_in(argument)) {
      std::tie(literal->begin, literal->end) = std::pair(argument.begin, argument.end);
      return literal;
    }
    TextCursor cursor(text_, argument.begin, argument.end);
    const std::string name = cursor.take_name();
    if (cursor.done()) {
      const auto found = variables_.find(name);
      if (found == variables_.end() || found->second.values != 1) return std::nullopt;
      std::optional<UrValue> value = found->second.literal;
      if (value) std::tie(value->begin, value->end) = std::pair(argument.begin, argument.end);
      return value;
    }
    if (cursor.next() != '(' || depth > 2) return std::nullopt;
    const size_t open = cursor.at(), close = closing(open, argument.end);
    TextCursor rest(text_, std::min(close + 1, argument.end), argument.end);
    if (!rest.done()) return std::nullopt;
    const std::vector<Statement> arguments = arguments_in(argument.line, open, close);
    if (name == "GET_INVERSE_KIN") return inverse_of(arguments, depth);
    if (name != "POSE_TRANS" || arguments.size() != 2) return std::nullopt;
    auto value = value_of(arguments[1], depth + 1);
    if (!value || value->kind != TargetKind::cartesian || value->base >= 0) return std::nullopt;
    std::optional<Pose> pose;
    if (const auto frame = value_of(arguments[0], depth + 1);
        frame && frame->kind == TargetKind::cartesian && frame->base < 0)
      pose = pose_of_numbers(Dialect::urscript, *frame->list.numbers(6));
    value->base = add_frame(program_.frames, known_, part_of(arguments[0]), pose);
    return value;
  }

  // Its pose, near the joints of qnear.
  std::optional<UrValue> inverse_of(const std::vector<Statement>& arguments, int depth) {
    auto value = value_of(arguments[0], depth + 1);
    if (!value || value->kind != TargetKind::cartesian) return std::nullopt;
    for (size_t i = 1; i < arguments.size(); ++i) {
      Statement near = arguments[i];
      TextCursor cursor(text_, near.begin, near.end);
      const std::string name = cursor.take_name();
      if (cursor.take('=')) {
        if (name == "TCP") return std::nullopt;
        if (name != "QNEAR") continue;
        cursor.next();
        near.begin = cursor.at();
      } else if (i > 1) {
        continue;
      }
      const auto joints = value_of(near, depth + 1);
      if (!joints || joints->kind != TargetKind::joints) return std::nullopt;
      value->near = joints_of_numbers(Dialect::urscript, *joints->list.numbers(6));
    }
    return value;
  }

  void add_target(const UrValue& value, int line, bool is_straight) {
    ProgramTarget target;
    target.line = line;
    target.kind = value.kind;
    target.base = value.base;
    target.tool = tool_;
    target.near = value.near;
    target.configuration.continues = is_straight;
    const std::vector<double> numbers = *value.list.numbers(6);
    if (value.kind == TargetKind::joints)
      target.q = joints_of_numbers(Dialect::urscript, numbers);
    else
      target.pose = pose_of_numbers(Dialect::urscript, numbers);
    target.point = point_of(value);
    program_.targets.push_back(target);
  }

  int point_of(const UrValue& value) {
    const auto variable = variables_.find(value.name);
    if (variable != variables_.end() && variable->second.point >= 0) return variable->second.point;
    ProgramPoint point;
    point.name = value.name;
    point.line = value.line;
    point.kind = value.kind;
    for (const ListItem& item : value.list.items)
      point.numbers.push_back({0, item.begin, item.end, item.value, ""});
    program_.points.push_back(point);
    const int index = static_cast<int>(program_.points.size()) - 1;
    if (variable != variables_.end()) variable->second.point = index;
    return index;
  }

  RobotProgram& program_;
  const KnownFrames& known_;
  std::string text_;
  ProgramWarnings warnings_;
  std::map<std::string, UrVariable> variables_;
  int tool_ = -1;
  bool is_move_ = false;  // the statement moves the arm
  bool follows_ = false;  // the arm stands at the last target
};

}  // namespace

void parse_urscript_program(RobotProgram& program, const KnownFrames& known) {
  UrReader(program, known).read();
}

}  // namespace armtrue
