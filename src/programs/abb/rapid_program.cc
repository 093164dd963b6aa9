#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "programs/abb/rapid_data.h"
#include "programs/abb/rapid_flow.h"
#include "programs/abb/rapid_insertion.h"
#include "programs/abb/rapid_parts.h"
#include "programs/abb/rapid_values.h"
#include "programs/abb/rapid_words.h"
#include "programs/move_reader.h"
#include "programs/statement.h"

// Programs of ABB controllers: RAPID reference manual, "Instructions, functions and data types":
// robtarget, jointtarget, confdata, tooldata, wobjdata, MoveJ, MoveL, MoveC, MoveAbsJ and those of
// their family, TriggJ, TriggL, TriggC.

namespace armtrue {
namespace {

class RapidReader : MoveReader {
  friend class MoveReader;

 public:
  RapidReader(RobotProgram& program, const KnownFrames& known, TargetParts parts)
      : MoveReader(program),
        parts_(parts),
        text_(masked_rapid(program.texts[0].text)),
        data_(program, text_, known, parts) {}

  void read() {
    const std::vector<Statement> statements = split_statements(text_, ';');
    data_.read(statements);
    flow_ = follow_with_others(statements);
    data_.set_flow(flow_.steps);
    for (const Statement& statement : statements) {
      is_move_ = false;
      each_rapid_word(text_, statement,
                      [&](const std::string& word, size_t at, const TextCursor& cursor) {
                        find_whether_it_runs(word, at, cursor);
                        return read_instruction(word, at, cursor, statement);
                      });
      read_late_move(statement);
      if (!is_move_) follows_ = follows_ && stays(statement);
    }
    follow_calls(calls_, of_parameters_, "its point is a parameter of the routine", *this);
    find_ways(flow_.steps);
    for (const RapidData::Use& use : data_.finish())
      leave_move(use.line, "uses the point " + use.name + " in a way that is not followed",
                 use.may_move);
    program_.warnings = warnings_.list();
  }

 private:
  // What calls of other modules hand on and leave, too.
  RapidFlow follow_with_others(std::vector<Statement> statements) const {
    std::string text = text_;
    for (size_t i = program_.own_texts; i < program_.texts.size(); ++i) {
      if (program_.texts[i].name != kRapidOthers) continue;
      std::string others = program_.texts[i].text;
      const size_t begin = text.size();
      for (const Statement& statement : split_statements(others, ';'))
        statements.push_back({0, begin + statement.begin, begin + statement.end});
      text += others;
    }
    return follow_rapid(text, statements);
  }

  // Whether the arm stays where it is during a statement without a move, and the next one follows.
  bool stays(const Statement& statement) const {
    TextCursor cursor(text_, statement.begin, statement.end);
    return stands_between_rapid_moves(cursor.take_name()) ||
           is_plain_assignment(text_, statement.begin, statement.end);
  }

  // %"MoveL"%p1,v100,fine,tool1;
  void read_late_move(const Statement& statement) {
    const std::string& original = program_.texts[0].text;
    for (size_t at = text_.find("%\"", statement.begin); at < statement.end;
         at = text_.find("%\"", at + 1)) {
      const std::string name = upper(original.substr(at + 2, text_.find('"', at + 2) - at - 2));
      if (!find_rapid_move(name)) continue;
      leave(line_at(original, statement, at), "this instruction is called by its name: " + name);
      is_move_ = true;
      follows_ = false;
    }
  }

  // A local routine is called in its module or never.
  void find_whether_it_runs(const std::string& word, size_t at, TextCursor cursor) {
    const bool is_local = std::exchange(word_before_, word) == "LOCAL";
    if (begins_rapid_routine(word)) {
      const std::string name = take_rapid_routine(word, cursor);
      is_called_ = !is_local || count_of(name) > 1 || text_.find("%\"") != std::string::npos ||
                   count_of("CALLBYVAR") > 0;
    }
    may_run_ = is_called_ && flow_.steps.leads_to(at);
  }

  int count_of(const std::string& name) {
    if (words_.empty())
      each_word(text_, {0, 0, text_.size()},
                [&](const std::string& word, size_t, const TextCursor&) { ++words_[word]; });
    const auto found = words_.find(name);
    return found == words_.end() ? 0 : found->second;
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

  // Returns whether the word begins an instruction that takes what follows.
  bool read_instruction(const std::string& word, size_t at, TextCursor cursor,
                        const Statement& statement) {
    const RapidMove* const move = find_rapid_move(word);
    if (data_.hands_points_to(word) && cursor.next() != '(' && cursor.next() != ':')
      calls_.push_back({word, line_at(program_.texts[0].text, statement, at),
                        data_.arguments_of_call(cursor, statement.end), may_run_});
    if (!move && !is_other_rapid_move(word, cursor)) return false;
    if (cursor.next() == '(' || cursor.next() == ':' || (!move && cursor.done())) return false;
    const int line = line_at(program_.texts[0].text, statement, at);
    is_left_ = false;
    is_move_ = true;
    if (move) {
      move_ = {move, at, statement.end, statement.begin == at, {}, {}};
      read_move(*move, line, cursor.at(), statement.end);
    } else {
      leave(line, "this instruction is not followed: " + word);
    }
    follows_ = !is_left_ && !is_conditional(statement.begin, at);
    return true;
  }

  void leave(int line, const std::string& reason) {
    leave_move(line, reason, may_run_);
    is_left_ = true;
  }

  void read_move(const RapidMove& move, int line, size_t begin, size_t end) {
    std::string why_not;
    ProgramTarget target;
    target.line = line;
    target.kind = move.is_joint_target ? TargetKind::joints : TargetKind::cartesian;
    std::vector<Statement> arguments = read_arguments(target.kind, begin, end, why_not);
    constexpr size_t kLeast = 2;  // of a process move behind its points: speed and tool
    if (move.is_process() ? arguments.size() < static_cast<size_t>(move.points) + kLeast
                          : arguments.size() <= static_cast<size_t>(move.tool))
      return leave(line, "its arguments are not those of the instruction");
    const size_t tool = move.is_process() ? arguments.size() - 1 : static_cast<size_t>(move.tool);
    if (move.is_joint_target)
      if (const auto pose = pose_of_joints(arguments[0], arguments[tool])) {
        target.kind = TargetKind::cartesian;
        arguments[0] = *pose;
      }
    if (const auto parameter = data_.parameter_at(arguments[0]); parameter && move.points == 1) {
      of_parameters_.push_back({*parameter, move_, line, target.kind, arguments[tool],
                                arguments[tool - 1], work_object_, why_not, may_run_});
      is_left_ = true;
      return;
    }
    if (why_not.empty()) set_frames(arguments[tool], target, why_not);
    const ProgramTarget* const in_frames = why_not.empty() ? &target : nullptr;
    std::vector<int> points;
    for (int i = 0; i < move.points && why_not.empty(); ++i)
      points.push_back(data_.point_at(arguments[i], target.kind, line, why_not));
    if (!why_not.empty()) {
      for (int i = 0; i < move.points; ++i) data_.leave(arguments[i], in_frames);
      return leave(line, why_not);
    }
    const char kind = move_.kind();
    const Statement& zone = arguments[tool - 1];
    target.blend = data_.radius_of_zone(zone);
    const int turning = flow_.turning.at(move_.begin);
    const bool is_certain = kind != 'C' || turning != ProgramFlow::kUncertain;
    target.turning = is_certain ? static_cast<ArcTurning>(turning) : ArcTurning::with_path;
    for (size_t i = 0; i < points.size(); ++i) {
      const bool is_auxiliary = i + 1 < points.size();
      target.motion = motion_of(kind, !is_auxiliary);
      target.follows_target = is_certain && (i > 0 || (follows_ && move_.is_first));
      // The tool goes straight along the part, not in the room.
      target.follows_target &= !target.is_inverse;
      target.begin = arguments[i].begin;
      target.end = arguments[i].end;
      if (target.is_inverse)
        target.obstacle = "its tool stands in the room";
      else if (kind == 'L' || target.motion == MotionKind::arc)
        prepare_rapid_insertion(program_, text_, move_, data_.external(), points, arguments,
                                target);
      add_target(target, points[i], is_auxiliary);
    }
  }

  // A move to a parameter of its procedure.
  struct MoveToParameter {
    RoutineParameter parameter;
    RapidMoveText move;
    int line;
    TargetKind kind;
    Statement tool, zone;
    std::optional<Statement> work_object;
    std::string why_not;
    bool may_run;
  };

  bool only_moves_use(const RoutineParameter& parameter) const {
    return data_.only_moves_use(parameter);
  }

  void keep(const Statement& argument) { data_.keep(argument); }

  void read_handed(const HandingCall& call, const Statement& argument,
                   const std::vector<const MoveToParameter*>& moves) {
    std::string why_not;
    std::optional<ProgramTarget> agreed;
    int agreed_reading = 0;
    bool may_run = false;
    for (const MoveToParameter* const move : moves) {
      const ProgramTarget target = target_of(*move, call, why_not);
      const int reading = reads_configuration();
      if (!agreed) agreed = target, agreed_reading = reading;
      if (!drives_alike(*agreed, target) || agreed_reading != reading)
        why_not = "its routine drives to it with several tools, work objects or settings";
      may_run |= move->may_run;
    }
    int point = -1;
    if (why_not.empty()) point = data_.point_at(argument, agreed->kind, call.line, why_not);
    if (!why_not.empty()) {
      keep(argument);
      return leave_move(call.line, why_not, call.may_run);
    }
    agreed->line = call.line;
    agreed->begin = argument.begin;
    agreed->end = argument.end;
    agreed->obstacle = "its point is handed to a routine";
    may_run_ = may_run && call.may_run;
    add_target(*agreed, point, false);
  }

  // Without its point.
  ProgramTarget target_of(const MoveToParameter& move, const HandingCall& call,
                          std::string& why_not) {
    move_ = move.move;
    work_object_ = move.work_object;
    if (work_object_) work_object_ = meant_by(call, *work_object_);
    ProgramTarget target;
    target.kind = move.kind;
    if (why_not.empty()) why_not = move.why_not;
    if (why_not.empty()) set_frames(meant_by(call, move.tool), target, why_not);
    target.blend = data_.radius_of_zone(meant_by(call, move.zone));
    target.motion = motion_of(move_.kind(), true);
    return target;
  }

  // What stands for a part of the procedure that is called.
  Statement meant_by(const HandingCall& call, const Statement& part) {
    const auto parameter = data_.parameter_at(part);
    const bool is_given = parameter && parameter->routine == call.routine &&
                          parameter->position < call.arguments.size();
    return is_given ? call.arguments[parameter->position] : part;
  }

  // MoveAbsJ CalcJointT(p10,tool1\WObj:=wobj1),..,tool1\WObj:=wobj1 goes to p10 as MoveJ does. Only
  // with the tool and the work object of the move.
  std::optional<Statement> pose_of_joints(const Statement& argument, const Statement& tool) const {
    TextCursor cursor(text_, argument.begin, argument.end);
    if (cursor.take_name() != "CALCJOINTT" || !cursor.take('(') || text_[argument.end - 1] != ')')
      return std::nullopt;
    cursor.next();
    const auto parts = split_arguments(text_, cursor.at(), argument.end - 1, ",");
    if (parts.size() != 2) return std::nullopt;
    const auto plain = [&](const Statement& part) {
      return compact(std::string_view(text_).substr(part.begin, part.end - part.begin));
    };
    std::string of_move = plain(tool);
    if (work_object_) of_move += "\\WOBJ:=" + plain(*work_object_);
    return plain(parts[1]) == of_move ? std::optional(parts[0]) : std::nullopt;
  }

  // The arguments without options; those with their options go into the move.
  std::vector<Statement> read_arguments(TargetKind kind, size_t begin, size_t end,
                                        std::string& why_not) {
    std::vector<Statement> arguments;
    work_object_.reset();
    for (const Statement& part : split_arguments(text_, begin, end, ",")) {
      const std::vector<Statement> pieces = split_arguments(text_, part.begin, part.end, "\\");
      for (size_t i = 0; i < pieces.size(); ++i) {
        const bool is_option = i > 0;
        if (!is_option && pieces[i].begin < pieces[i].end) {
          arguments.push_back(without_name(pieces[i]));
          move_.parts.push_back(part);
        }
        if (!is_option) continue;
        TextCursor cursor(text_, pieces[i].begin, pieces[i].end);
        move_.options.push_back(cursor.take_name());
        if (move_.options.back() != "WOBJ") continue;
        if (!cursor.take(':') || !cursor.take('='))
          why_not = data_.why_not_of_routine(kind);  // \WObj?WObj
        cursor.next();
        work_object_ = Statement{0, cursor.at(), pieces[i].end};
      }
    }
    return arguments;
  }

  // ToPoint:=p1: the names of arguments change nothing in their order.
  Statement without_name(const Statement& argument) const {
    TextCursor cursor(text_, argument.begin, argument.end);
    if (cursor.take_name().empty() || !cursor.take(':') || !cursor.take('=')) return argument;
    cursor.next();
    return {argument.line, cursor.at(), argument.end};
  }

  void set_frames(const Statement& tool, ProgramTarget& target, std::string& why_not) {
    if (const int displacement = flow_.displacement.at(move_.begin); displacement != 0)
      why_not = displacement == 1 ? "a program displacement (PDispOn, PDispSet) is active"
                                  : "a program displacement (PDispOn, PDispSet) may be active";
    if (!why_not.empty()) return;
    const RapidData::Frame object = work_object_
                                        ? data_.work_object_at(*work_object_, target.kind, why_not)
                                        : data_.room_frame();
    if (!why_not.empty()) return;
    const RapidData::Frame of_tool = data_.tool_at(tool, target.kind, why_not);
    target.base = object.index;
    target.tool = of_tool.index;
    if (why_not.empty() && of_tool.is_held == false)
      set_room_tool(object, target, why_not);
    else if (why_not.empty() && object.is_held == true)
      why_not = "the robot holds the work object, and its tool is not known to stand in the room";
  }

  // The tool is fixed in the room, and the robot holds the part: tool and work object have
  // exchanged roles.
  void set_room_tool(const RapidData::Frame& object, ProgramTarget& target, std::string& why_not) {
    if (object.is_held != true || parts_ != TargetParts::pose) {
      why_not = "its tool stands in the room";
      return;
    }
    std::swap(target.base, target.tool);
    target.is_room_tool = true;
    target.is_inverse = target.kind == TargetKind::cartesian;
  }

  void add_target(ProgramTarget target, int index, bool is_auxiliary) {
    target.never_runs = !may_run_;
    if (target.kind == TargetKind::cartesian) {
      target.configuration = configuration_of(program_.points[index]);
      target.configuration.continues = is_auxiliary;
    }
    target.other_axes = other_axes_of(index);
    add_target_at(std::move(target), index);
  }

  // eax_a to eax_f that are in use.
  std::map<std::string, double> other_axes_of(int index) const {
    std::map<std::string, double> axes;
    const auto external = data_.external().find(index);
    if (external == data_.external().end()) return axes;
    for (size_t i = 0; i < external->second.size(); ++i)
      if (is_rapid_axis(external->second[i]))
        axes[std::string("eax_") + static_cast<char>('a' + i)] = external->second[i];
    return axes;
  }

  // Without ConfJ or ConfL the controller does not read confdata. Where that is not certain, they
  // count if the arm reaches the point so. CalcJointT always reads them.
  Configuration configuration_of(const ProgramPoint& point) const {
    const int counts = reads_configuration();
    if (counts == 0) return {};
    Configuration result = rapid_configuration(point);
    result.is_weak = counts == ProgramFlow::kUncertain;
    return result;
  }

  // Whether the controller does for this move: 1, 0 or kUncertain.
  int reads_configuration() const {
    if (move_.kind_of->is_joint_target) return 1;
    return (move_.kind() == 'J' ? flow_.confj : flow_.confl).at(move_.begin);
  }

  const TargetParts parts_;
  std::string text_;
  RapidData data_;
  RapidFlow flow_;
  RapidMoveText move_;                       // that is read
  std::optional<Statement> work_object_;     // of this move; nothing: wobj0
  std::vector<MoveToParameter> of_parameters_;
  std::vector<HandingCall> calls_;
  bool is_move_ = false;                     // the statement moves the arm
  bool is_left_ = false;                     // the move that is read is left alone
  bool follows_ = false;                     // the arm stands at the last target
  bool is_called_ = true;                    // the routine, perhaps
  bool may_run_ = true;                      // what is read; else no way leads to it
  std::string word_before_;
  std::map<std::string, int> words_;  // how often each stands in the text
};

}  // namespace

void parse_rapid_program(RobotProgram& program, const KnownFrames& known, TargetParts parts) {
  RapidReader(program, known, parts).read();
}

}  // namespace armtrue
