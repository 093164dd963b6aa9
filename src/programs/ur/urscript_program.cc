#include "programs/ur/urscript_program.h"

#include <algorithm>
#include <optional>
#include <set>

#include "programs/dialects.h"
#include "programs/frame_list.h"
#include "programs/move_reader.h"
#include "programs/statement.h"
#include "programs/ur/urscript_structure.h"
#include "programs/ur/urscript_values.h"

// Programs of Universal Robots: the URScript programming language, module motion: movej, movel,
// movep, movec, optimovej, optimovel, with poses p[x,y,z,rx,ry,rz] in m and rad and joints [..] in
// rad; get_inverse_kin, pose_trans, set_tcp.

namespace armtrue {
namespace {

// Functions that leave the arm where it is.
bool stands_between_ur_moves(const std::string& word) {
  return contains({"SET_TCP", "SET_DIGITAL_OUT", "SET_STANDARD_DIGITAL_OUT",
                   "SET_CONFIGURABLE_DIGITAL_OUT", "SET_ANALOG_OUT", "SET_TOOL_DIGITAL_OUT",
                   "SET_STANDARD_ANALOG_OUT", "SET_PAYLOAD", "SET_PAYLOAD_COG", "SET_PAYLOAD_MASS",
                   "SET_TARGET_PAYLOAD", "SET_GRAVITY", "SET_FLAG", "SLEEP", "SYNC", "TEXTMSG"},
                  word);
}

bool drives_straight(const std::string& move) { return move.back() != 'J'; }

class UrReader : MoveReader {
  friend class MoveReader;

 public:
  UrReader(RobotProgram& program, const KnownFrames& known, TargetParts parts)
      : MoveReader(program),
        known_(known),
        parts_(parts),
        text_(masked(program.texts[0].text, '#', "\"'")),
        statements_(split_statements(text_, '\n')),
        values_(text_, program.texts[0].text, program.frames, known) {}

  void read() {
    const std::vector<Statement>& statements = statements_;
    structure_ = structure_of_urscript(text_, statements);
    values_.read(statements, structure_);
    for (const UrParameter& parameter : structure_.parameters)
      functions_with_parameters_.insert(parameter.parameter.routine);
    find_tools(statements, structure_.flow);
    find_conveyors(statements, structure_.flow);
    for (const Statement& statement : statements) {
      is_move_ = false;
      read_calls(statement);
      if (!is_move_) follows_ = follows_ && stays(statement);
    }
    values_.note_uses(statements, program_.targets);
    follow_calls(calls_, of_parameters_, "its point is a parameter of the function", *this);
    values_.finish(statements, program_.targets, program_.points);
    find_ways(structure_.flow);
    program_.warnings = warnings_.list();
  }

 private:
  // Whether the arm stays where it is during a statement without a move, and the next one follows.
  bool stays(const Statement& statement) const {
    TextCursor cursor(text_, statement.begin, statement.end);
    TextCursor assigned = cursor;
    const std::string word = cursor.take_name();
    if (word == "GLOBAL" || word == "LOCAL") assigned = cursor;
    // PolyScope names each of its nodes: $ 3 "Waypoint_1"
    return word.starts_with('$') || (stands_between_ur_moves(word) && cursor.next() == '(') ||
           (is_plain_assignment(text_, assigned.at(), statement.end) && !ends_block(statement));
  }

  // x = 1 end
  bool ends_block(const Statement& statement) const {
    bool found = false;
    each_word(text_, statement, [&](const std::string& word, size_t, const TextCursor&) {
      found |= word == "END" || word == "ELSE" || word == "ELIF";
    });
    return found;
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
      const size_t close = values_.closing(open, statement.end);
      if (is_ur_move(word)) {
        const int left_alone = program_.left_alone;
        const bool is_first = begin == statement.begin;
        follows_ = follows_ && is_first;
        is_move_ = true;
        read_move(word, statement, open, close);
        follows_ = is_first && ends_at_target_ && program_.left_alone == left_alone &&
                   ends_at(close, statement.end);
      }
      if (functions_with_parameters_.contains(word))
        calls_.push_back({word, statement.line, values_.arguments_in(statement.line, open, close),
                          may_run(begin)});
      if (is_other_ur_motion(word)) {
        leave_move(statement.line, "this function is not followed: " + word, may_run(begin));
        is_move_ = true;
        follows_ = false;
      }
    }
  }

  bool may_run(size_t at) const {
    return std::ranges::none_of(structure_.never_run, [&](const auto& part) {
      return part.first <= at && at < part.second;
    });
  }

  // Whether nothing stands behind the bracket that closes a call.
  bool ends_at(size_t close, size_t end) const {
    TextCursor behind(text_, std::min(close + 1, end), end);
    behind.take(';');
    return behind.done();
  }

  void find_tools(const std::vector<Statement>& statements, const ProgramFlow& flow) {
    std::vector<ProgramFlow::Setting> tools;
    std::vector<Restored> restored;
    for (const Statement& statement : statements)
      each_word(text_, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
        if (word != "SET_TCP" || cursor.next() != '(') return;
        const size_t open = cursor.at(), close = values_.closing(open, statement.end);
        const Statement argument = values_.arguments_in(statement.line, open, close)[0];
        if (const auto place = values_.place_of_tool(argument)) {
          restored.push_back({tools.size(), *place});
          tools.push_back({at, ProgramFlow::kUncertain});
        } else {
          tools.push_back({at, tool_of(argument)});
        }
      });
    tools_ = restored.empty() ? flow.follow(tools, kNoTool) : with_restored(tools, restored, flow);
  }

  // Where moves follow a conveyor: they do not end where they say.
  void find_conveyors(const std::vector<Statement>& statements, const ProgramFlow& flow) {
    std::vector<ProgramFlow::Setting> settings;
    for (const Statement& statement : statements)
      each_word(text_, statement, [&](const std::string& word, size_t at, TextCursor cursor) {
        if (cursor.next() != '(') return;
        if (word == "TRACK_CONVEYOR_LINEAR" || word == "TRACK_CONVEYOR_CIRCULAR")
          settings.push_back({at, kFollows});
        if (word == "STOP_CONVEYOR_TRACKING") settings.push_back({at, kStands});
      });
    conveyors_ = flow.follow(settings, kStands);
  }

  // set_tcp(NAME) behind NAME=get_tcp_offset().
  struct Restored {
    size_t setting;
    size_t place;  // where the name gets the tool
  };

  // If all restored tools were one and the same, and then it is the tool of all these places, it
  // is.
  static ProgramFlow::Values with_restored(std::vector<ProgramFlow::Setting> tools,
                                           const std::vector<Restored>& restored,
                                           const ProgramFlow& flow) {
    std::set<int> candidates{kNoTool};
    for (const ProgramFlow::Setting& tool : tools) candidates.insert(tool.value);
    candidates.erase(ProgramFlow::kUncertain);
    const auto follow_with = [&](int tool) {
      for (const Restored& by : restored) tools[by.setting].value = tool;
      return flow.follow(tools, kNoTool);
    };
    for (const int tool : candidates) {
      const ProgramFlow::Values values = follow_with(tool);
      if (std::ranges::all_of(restored,
                              [&](const Restored& by) { return values.at(by.place) == tool; }))
        return values;
    }
    return follow_with(ProgramFlow::kUncertain);
  }

  // In the frames.
  int tool_of(const Statement& argument) {
    if (values_.names_local(argument)) return ProgramFlow::kUncertain;
    const int tool = add_frame(program_.frames, known_, values_.part_of(argument),
                               values_.constant_pose(argument));
    const bool is_known = program_.frames[tool].is_known;
    return !is_known && values_.names_several(argument) ? ProgramFlow::kUncertain : tool;
  }

  void read_move(const std::string& word, const Statement& statement, size_t open, size_t close) {
    const int line = statement.line;
    ends_at_target_ = true;
    const std::vector<Statement> arguments = values_.arguments_in(line, open, close);
    const size_t points = word == "MOVEC" ? 2 : 1;
    if (arguments.size() < points)
      return leave_move(line, "its arguments are not those of the function", may_run(open));
    if (points == 1)
      if (const auto parameter = values_.parameter_in(arguments[0])) {
        of_parameters_.push_back(
            {*parameter, line, open, arguments[0], drives_straight(word), may_run(open)});
        ends_at_target_ = false;
        return;
      }
    std::vector<UrValue> values;
    std::string why_not;
    for (size_t i = 0; i < points && why_not.empty(); ++i)
      if (const auto value = value_at(arguments[i], open, why_not)) values.push_back(*value);
    if (!why_not.empty()) {
      for (size_t i = 0; i < points; ++i) values_.leave(arguments[i], tools_.at(open));
      return leave_move(line, why_not, may_run(open));
    }
    for (UrValue& value : values) value.open = open;
    const Options options = options_of(arguments, points, word);
    ends_at_target_ = !options.has_mode;
    follows_ = follows_ && ends_at_target_;
    for (size_t i = 0; i < points; ++i) {
      const bool is_last = i + 1 == points;
      ProgramTarget& target = add_target(values[i], line, drives_straight(word));
      target.motion = motion_of(word == "MOVEP" ? 'L' : word.back(), is_last);
      if (!is_last) find_orientation(target, values);
      target.follows_target = (i > 0 && ends_at_target_) || follows_;
      target.blend = options.radius.value_or(0);
      if (target.motion == MotionKind::line || target.motion == MotionKind::arc)
        prepare_insertion(target, values, options, statement, close);
    }
  }

  // The controller does not use the orientation of an auxiliary point, and its manual leaves zeros
  // there: the arm has that of the way, which the end is nearer to.
  static void find_orientation(ProgramTarget& target, const std::vector<UrValue>& values) {
    const UrValue &via = values.front(), &end = values.back();
    if (via.kind != TargetKind::cartesian || end.kind != via.kind || end.base != via.base) return;
    const auto numbers = *via.list.numbers(6), of_end = *end.list.numbers(6);
    if (numbers[3] != 0 || numbers[4] != 0 || numbers[5] != 0) return;
    target.has_orientation = false;
    target.pose.rotation = urscript_dialect().pose_of_numbers(of_end).rotation;
  }

  // The value of the point of a move, and its tool; nothing and why if one is not known.
  std::optional<UrValue> value_at(const Statement& argument, size_t move, std::string& why_not) {
    const auto value = values_.value_of(argument);
    const int tool = tools_.at(move);
    const bool is_certain = tool != ProgramFlow::kUncertain;
    tool_ = is_certain ? tool : -1;
    if (!value)
      why_not = values_.why_not(argument);
    else if (conveyors_.at(move) != kStands)
      why_not = "it may follow a conveyor, which track_conveyor.. before it begins";
    else if (value->is_in_calculated_frame && parts_ == TargetParts::pose)
      why_not =
          "its frame is calculated at run time; if it is always the same, give it with "
          "--frame";
    else if (!is_certain && value->kind == TargetKind::cartesian && parts_ == TargetParts::pose)
      why_not = "its tool is not certain: set_tcp depends on calls or branches before it";
    return why_not.empty() ? value : std::nullopt;
  }

  // A move to a parameter of its function.
  struct MoveToParameter {
    RoutineParameter parameter;
    int line;
    size_t open;
    Statement argument;
    bool is_straight;
    bool may_run = true;
  };

  bool only_moves_use(const RoutineParameter& parameter) {
    return values_.only_moves_use(parameter);
  }

  void keep(const Statement&) {}  // what stands in no move stays

  void read_handed(const HandingCall& call, const Statement& argument,
                   const std::vector<const MoveToParameter*>& moves) {
    values_.hand_over(call.routine, call.arguments);
    std::string why_not;
    std::optional<UrValue> agreed;
    ProgramTarget target;
    for (const MoveToParameter* const move : moves) {
      const auto value = value_at(move->argument, move->open, why_not);
      if (!values_.value_of(argument)) why_not = values_.why_not(argument);
      if (!value || !why_not.empty()) break;
      const ProgramTarget here = target_of(*value, call.line, move->is_straight);
      if (!agreed) agreed = value, target = here;
      if (!drives_alike(target, here))
        why_not = "its function drives to it with several tools or frames";
    }
    if (!why_not.empty()) return leave_move(call.line, why_not, call.may_run);
    target.motion = motion_of(moves.front()->is_straight ? 'L' : 'J', true);
    target.obstacle = "its point is handed to a function";
    add_shifted(target, values_.point_of(*agreed, program_.points));
  }

  // What stands behind the points of a move.
  struct Options {
    std::string kept;              // without time and radius
    std::optional<double> radius;  // 0 if none is given; nothing if it is an expression
    bool has_time = false;
    bool has_mode = false;  // of movec: the tool turns with the arc, whatever the end states
  };

  // By name or in this order: movej and movel: a, v, t, r; others: a, v, r; movec: mode, too.
  Options options_of(const std::vector<Statement>& arguments, size_t points,
                     const std::string& word) const {
    Options options;
    options.radius = 0;
    std::vector<std::string> names{"A", "V", "R", "MODE"};
    if (word == "MOVEJ" || word == "MOVEL") names = {"A", "V", "T", "R"};
    for (size_t i = points; i < arguments.size(); ++i) {
      const Statement& argument = arguments[i];
      TextCursor cursor(text_, argument.begin, argument.end);
      std::string name = cursor.take_name();
      if (name.empty() || !cursor.take('=')) {
        cursor = TextCursor(text_, argument.begin, argument.end);
        name = i - points < names.size() ? names[i - points] : "";
      }
      const auto value = cursor.take_number();
      const bool is_plain = value && cursor.done();
      if (name == "T")
        options.has_time |= !is_plain || *value != 0;
      else if (name == "R")
        options.radius = is_plain ? value : std::nullopt;
      else if (name == "MODE")
        options.has_mode = !is_plain || *value != 0;
      else
        options.kept += ", " + values_.part_of(argument);
    }
    return options;
  }

  void prepare_insertion(ProgramTarget& target, const std::vector<UrValue>& values,
                         const Options& options, const Statement& statement, size_t close) const {
    const std::string& original = program_.texts[0].text;
    const size_t line = line_begin(original, statement.begin);
    for (const UrValue& value : values) {
      if (value.declared) target.obstacle = "its point is an expression";
      if (value.kind == TargetKind::joints) target.obstacle = "its point is joint angles";
    }
    if (options.has_mode) target.obstacle = "its tool turns with the arc (mode)";
    if (options.has_time) target.obstacle = "its speed is a time (t)";
    if (!options.radius) target.obstacle = "its radius is no plain number";
    if (!ends_at(close, statement.end) || !TextCursor(text_, line, statement.begin).done())
      target.obstacle = "it does not stand alone on its line";
    if (!target.obstacle.empty()) return;
    // A point may stand in pose_trans() or get_inverse_kin(): up to the end of the argument.
    const UrValue &first = values.front(), &last = values.back();
    const size_t end =
        values_.arguments_in(statement.line, last.open, close)[values.size() - 1].end;
    ProgramInsertion& beside = target.insertion;
    beside.at = line;
    beside.before = text_.substr(line, first.begin - line);
    beside.behind = text_.substr(last.end, end - last.end) + options.kept + ", r=";
    beside.line_end = line_end(original, close);
    if (values.size() > 1) beside.middle = text_.substr(first.end, last.begin - first.end);
    for (std::string* text : {&beside.before, &beside.middle, &beside.behind})
      std::ranges::replace(*text, '\r', ' ');
  }

  ProgramTarget& add_target(const UrValue& value, int line, bool is_straight) {
    return add_shifted(target_of(value, line, is_straight),
                       values_.point_of(value, program_.points));
  }

  // Where pose_add takes it.
  ProgramTarget& add_shifted(const ProgramTarget& target, int point) {
    ProgramTarget& added = add_target_at(target, point);
    added.pose.translation += added.before.translation;
    return added;
  }

  // Without its point.
  ProgramTarget target_of(const UrValue& value, int line, bool is_straight) const {
    ProgramTarget target;
    target.kind = value.kind;
    target.line = line;
    target.begin = value.begin;
    target.end = value.end;
    target.base = value.base;
    target.before.translation = value.shift;
    target.tool = tool_;
    target.never_runs = !may_run(value.begin);
    target.near = value.near;
    target.configuration.continues = is_straight;
    return target;
  }

  static constexpr int kNoTool = -1;  // that of the caller
  static constexpr int kStands = 0, kFollows = 1;

  const KnownFrames& known_;
  const TargetParts parts_;
  std::string text_;
  const std::vector<Statement> statements_;
  UrStructure structure_;
  UrValues values_;
  std::set<std::string> functions_with_parameters_;
  std::vector<MoveToParameter> of_parameters_;
  std::vector<HandingCall> calls_;
  ProgramFlow::Values tools_;   // in the frames
  ProgramFlow::Values conveyors_;
  int tool_ = -1;               // of the move that is read
  bool is_move_ = false;        // the statement moves the arm
  bool follows_ = false;        // the arm stands at the last target
  bool ends_at_target_ = true;  // the last move does, in its orientation too
};

}  // namespace

void parse_urscript_program(RobotProgram& program, const KnownFrames& known, TargetParts parts) {
  UrReader(program, known, parts).read();
}

}  // namespace armtrue
