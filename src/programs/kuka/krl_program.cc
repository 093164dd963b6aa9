#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "programs/frame_list.h"
#include "programs/kuka/krl_parts.h"
#include "programs/kuka/krl_set_up.h"
#include "programs/kuka/krl_starts.h"
#include "programs/kuka/krl_syntax.h"
#include "programs/kuka/krl_words.h"
#include "programs/kuka/krl_zones.h"
#include "programs/move_reader.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

// Programs of KUKA controllers: KSS 8.x, operating and programming instructions for system
// integrators, chapters "Motion programming" and "Status and Turn".

namespace armtrue {
namespace {

constexpr const char* kPoseNames[] = {"X", "Y", "Z", "A", "B", "C"};

// S and T. Bit 0 of S: the wrist lies behind axis 1; bit 1: the forearm is bent to the side of
// A3 = 90 deg; bit 2: A5 is below zero. T says the last one too, and more surely. Bits of T: joints
// below zero.
Configuration configuration_of(const KrlFrame& frame) {
  Configuration result;
  result.reference << 0, -90, 90, 0, 45, 0;
  result.reference *= kDegree;
  if (frame.turn)
    for (int j = 0; j < kProgramAxes; ++j)
      ((*frame.turn >> j) & 1 ? result.high : result.low)[j] = 0;
  if (frame.status) {
    result.sides = {*frame.status & 1 ? -1 : 1, *frame.status & 2 ? 1 : -1,
                    *frame.status & 4 ? -1 : 1};
    if (frame.turn) result.sides[2] = 0;
  }
  return result;
}

class KrlReader : MoveReader {
 public:
  KrlReader(RobotProgram& program, const KrlSyntax& syntax, const KnownFrames& known,
            TargetParts parts)
      : MoveReader(program),
        syntax_(syntax),
        known_(known),
        parts_(parts),
        unused_(program.texts[0].name),
        set_ups_(KrlSetUps(program.texts[0].text, syntax, program.neighbours, known, program.frames,
                           parts == TargetParts::pose ? warnings_ : unused_)
                     .read()),
        starts_(syntax, set_ups_, parts),
        zones_(program.texts[0].text, syntax),
        end_of_move_(syntax.moves.size(), -1),
        point_of_frame_(syntax.frames.size(), -1),
        point_of_axes_(syntax.axes.size(), -1),
        is_left_alone_(syntax.frames.size(), false),
        counted_(program.texts.size(), {0, 1}) {}

  void read() {
    program_.own_model_line = syntax_.absolute_accuracy_line;
    program_.own_model_text = syntax_.absolute_accuracy_text;
    program_.arm_name = syntax_.arm_name;
    program_.arm_name_text = syntax_.arm_name_text;
    program_.arm_name_line = syntax_.arm_name_line;
    find_what_runs();
    for (size_t i = 0; i < syntax_.moves.size(); ++i) read_move(i);
    find_starts();
    find_ways(syntax_.steps.flow());
    for (const auto& [point, frame] : starts_of_points_)
      program_.points[point].starts_from = point_of_frame_[frame];
    for (size_t i = 0; i < program_.points.size(); ++i)
      if (frame_of_point_[i] >= 0 && is_left_alone_[frame_of_point_[i]])
        program_.points[i].is_shared = true;
    find_names();
    warn_of_callers();
    find_calls_not_given();
    count_bases_from_foot();
    program_.warnings = warnings_.list();
  }

 private:
  // A local subprogram is called in this text or never. The first one has the name of the file.
  void find_what_runs() {
    const std::string text = masked(program_.texts[0].text, ';', "\"");
    std::map<std::string, int> words;
    each_word(text, {0, 0, text.size()},
              [&](const std::string& word, size_t, const TextCursor&) { ++words[word]; });
    bool is_main = true, is_called = true;
    size_t next = 0;
    for (size_t i = 0; i < syntax_.moves.size(); ++i) {
      for (; next < syntax_.moves[i].set_ups; ++next) {
        const KrlSetUp& definition = syntax_.set_ups[next];
        if (const auto head = krl_head(text, {definition.line, definition.begin, definition.end}))
          is_called = std::exchange(is_main, false) || head->is_global || words[head->name] > 1;
      }
      runs_.push_back(is_called && starts_.runs(i));
    }
  }

  void leave(size_t index, const std::string& reason) {
    const KrlMove& move = syntax_.moves[index];
    leave_move(move.line, reason, runs_[index]);
    for (const KrlTarget* target : {&move.auxiliary, &move.target})
      for (const int frame : {target->frame, target->starts_from})
        if (frame >= 0) is_left_alone_[frame] = true;
  }

  void read_move(size_t index) {
    const KrlMove& move = syntax_.moves[index];
    if (move.target.kind == KrlTargetKind::here && move.motion != KrlMotion::circle)
      return;  // the arm does not move
    if (const std::string reason = starts_.why_left_alone(index); !reason.empty())
      return leave(index, reason);
    if (move.circle_angle)
      warnings_.add(move.line,
                    "a circle with an angle does not end at its target: only its points are "
                    "corrected");
    if (move.motion == KrlMotion::circle) read_target(index, true);
    read_target(index, false);
    end_of_move_[index] = static_cast<int>(program_.targets.size()) - 1;
    for (size_t k = move_of_target_.size(); k < program_.targets.size(); ++k)
      program_.targets[k].never_runs = !runs_[index];
    move_of_target_.resize(program_.targets.size(), index);
  }

  // Of each target the targets at which its move may start.
  void find_starts() {
    for (size_t k = 0; k < program_.targets.size(); ++k)
      for (int move : starts_.moves_before(move_of_target_[k]))
        program_.targets[k].starts.push_back(end_of_move_[move]);
    if (syntax_.keeps_orientation && parts_ == TargetParts::pose)
      for (const ProgramTarget& target : program_.targets) warn_of_orientation(target);
  }

  // $TOOL and $BASE stay over a call, unless the routine sets them.
  void find_calls_not_given() {
    const std::string text = upper(masked(program_.texts[0].text, ';', "\""));
    const std::set<std::string> own = subprograms(text);
    std::set<size_t> tools;  // places that name one
    for (const char* const word : {"$TOOL", "FDAT"})
      for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
        tools.insert(at);
    auto next = program_.targets.begin();  // the first one behind the call
    for (const KrlCall& call : krl_calls(text)) {
      next = std::find_if(next, program_.targets.end(), [&](const ProgramTarget& target) {
        return target.begin > call.statement && target.kind == TargetKind::cartesian;
      });
      if (next == program_.targets.end()) return;
      const auto tool = tools.lower_bound(call.statement);
      const bool is_set_again = tool != tools.end() && *tool < next->begin;
      if (!call.is_statement || is_set_again || (next->base < 0 && next->tool < 0) ||
          find_krl_motion(call.name) || leaves_krl_arm(call.name, call.name) ||
          own.contains(call.name) || program_.neighbours.leaves.contains(call.name))
        continue;
      program_.calls_not_given.push_back({call.line, call.name});
    }
  }

  // Those of the .src, whose text is given in capitals.
  std::set<std::string> subprograms(const std::string& text) const {
    std::set<std::string> names;
    for (const KrlSetUp& definition : syntax_.set_ups)
      if (definition.word == "DEF")
        names.insert(krl_head(text, {definition.line, definition.begin, definition.end})->name);
    return names;
  }

  void warn_of_callers() {
    for (size_t k = 0; k < program_.targets.size(); ++k) {
      const ProgramTarget& target = program_.targets[k];
      if (target.kind != TargetKind::cartesian || !set_ups_.are_of_callers[move_of_target_[k]])
        continue;
      std::string callers;
      for (const auto& [routine, calls] : program_.neighbours.callers)
        callers += (callers.empty() ? "" : ", ") + calls;
      warnings_.add(target.line,
                    "$BASE and $TOOL are those with which other programs call this one "
                    "(" +
                        callers + "); if anything else starts it, it may have others");
      return;
    }
  }

  // $BASE counts from $WORLD, where the arm stands at $ROBROOT; what --frame states counts from
  // R_0.
  void count_bases_from_foot() {
    if (syntax_.robot_root < 0) return;
    const std::optional<Pose> root = krl_pose(syntax_.frames[syntax_.robot_root]);
    if (!root) return;
    const Pose foot_from_world = inverse(*root);
    if (foot_from_world.translation.isZero(0) && foot_from_world.rotation.isIdentity(0)) return;
    for (ProgramTarget& target : program_.targets) {
      if (target.base < 0 || !program_.frames[target.base].is_known) continue;
      const ProgramFrame base = program_.frames[target.base];
      if (is_given_frame(known_, base.name)) continue;
      target.base =
          add_frame(program_.frames, {}, base.name + " from $ROBROOT", foot_from_world * base.pose);
    }
  }

  // With $ORI_TYPE #CONSTANT the orientation of a target is not reached.
  void warn_of_orientation(const ProgramTarget& target) {
    if (target.kind != TargetKind::cartesian ||
        (target.motion != MotionKind::line && target.motion != MotionKind::arc))
      return;
    constexpr double kOther = 0.1 * kDegree;
    const bool is_same = std::ranges::all_of(target.starts, [&](size_t start) {
      const ProgramTarget& before = program_.targets[start];
      const Eigen::Matrix3d turn = target.pose.rotation * before.pose.rotation.transpose();
      return before.kind == TargetKind::cartesian && before.base == target.base &&
             rotation_log(turn).norm() < kOther;
    });
    if (target.starts.empty() || !is_same)
      warnings_.add(
          target.line,
          "$ORI_TYPE is #CONSTANT in this program: if it is for this move, the tool keeps "
          "the orientation with which it begins, and the correction is for another");
  }

  // Fills what stands beside the point of an inserted move. `given`: what the end states itself.
  void prepare_insertion(ProgramTarget& target, const KrlMove& move, const KrlValues& before,
                         const KrlValues& given) const {
    if (syntax_.circles_turn_with_path && target.motion == MotionKind::arc)
      target.obstacle = "$CIRC_TYPE is #PATH in this program";
    if (move.target.is_expression || move.auxiliary.is_expression)
      target.obstacle = "its point is an expression";
    if (move.circle_angle) target.obstacle = "its angle says where it ends";
    if (move.spline_block) target.obstacle = "it stands in a spline block";
    if (move.after_trigger) target.obstacle = "a TRIGGER refers to it";
    if (target.kind == TargetKind::joints ||
        (target.motion == MotionKind::arc && move.auxiliary.kind == KrlTargetKind::axes))
      target.obstacle = "its point is joint angles";
    for (int k = 6; k < kKrlComponents; ++k)
      if (std::isfinite(given[k]) && !std::isfinite(before[k]))
        target.obstacle = "an external axis before it is not known";
    if (!target.obstacle.empty()) return;
    const std::string& src = program_.texts[0].text;
    const std::string rest = src.substr(move.target.end, move.end - move.target.end);
    const bool is_arc = target.motion == MotionKind::arc;
    const KrlTarget& first = is_arc ? move.auxiliary : move.target;
    ProgramInsertion& beside = target.insertion;
    beside.at = move.line_begin;
    beside.before = src.substr(move.line_begin, first.begin - move.line_begin);
    beside.behind = rest + krl_blending(rest, move);
    beside.line_end = line_end(src, move.end);
    if (!is_arc) return;
    beside.middle = src.substr(first.end, move.target.begin - first.end);
    beside.before_line = src.substr(move.line_begin, move.begin - move.line_begin) +
                         (move.spline ? "SLIN" : "LIN") +
                         src.substr(move.keyword_end, first.begin - move.keyword_end);
  }

  static char kind_of(const KrlMove& move) {
    switch (move.motion) {
      case KrlMotion::point_to_point:
      case KrlMotion::spline_point:
        break;
      case KrlMotion::line:
        return 'L';
      case KrlMotion::circle:
        return 'C';
    }
    return 'J';
  }

  // Within a spline block the arm stops nowhere.
  bool passes(size_t index) const {
    const auto& moves = syntax_.moves;
    const KrlMove& move = moves[index];
    bool is_approximated = false;
    each_word(program_.texts[0].text, {move.line, move.target.end, move.end},
              [&](const std::string& word, size_t, const TextCursor&) {
                is_approximated |=
                    word == "C_DIS" || word == "C_VEL" || word == "C_ORI" || word == "C_SPL";
              });
    const bool is_within = move.spline_block && index + 1 < moves.size() &&
                           moves[index + 1].spline_block &&
                           moves[index + 1].spline_block->begin == move.spline_block->begin;
    return is_approximated || is_within;
  }

  void read_target(size_t index, bool is_auxiliary) {
    const KrlMove& move = syntax_.moves[index];
    const KrlTarget& target = is_auxiliary ? move.auxiliary : move.target;
    const KrlSetUps::SetUp& set_up = set_ups_.of_moves[index];
    const bool is_axes = target.kind == KrlTargetKind::axes;
    const KrlFrame& frame = is_axes ? syntax_.axes[target.axes] : syntax_.frames[target.frame];
    const KrlValues before = is_auxiliary ? starts_.before(index) : starts_.before_end(index);
    const KrlValues values = is_auxiliary ? inherit(before, frame.values) : starts_.reached(index);
    ProgramTarget result;
    result.line = move.line;
    result.begin = target.begin;
    result.end = target.end;
    result.is_relative = move.relative != KrlRelative::none;
    result.is_in_loop = move.in_loop;
    // A recorded path, along which positions alone are corrected, has its corners as they were
    // driven.
    if (parts_ == TargetParts::pose) result.blend = zones_.blend_of(move);
    result.is_passed = passes(index);
    result.ends_elsewhere = move.circle_angle && !is_auxiliary;
    result.is_room_tool = set_up.is_external_tcp;
    if (move.in_inline_form)
      result.remark =
          "points are written into an inline form; changing it on the pendant drops them";
    result.base = set_up.base;
    result.tool = set_up.tool;
    result.kind = is_axes ? TargetKind::joints : TargetKind::cartesian;
    result.motion = motion_of(kind_of(move), !is_auxiliary);
    result.follows_target = result.motion == MotionKind::arc
                                ? !move.circle_angle && !syntax_.circles_turn_with_path
                                : starts_.follows(index) && !syntax_.moves[index - 1].circle_angle;
    const int point = point_for(target, frame, values, is_auxiliary);
    if (result.motion == MotionKind::line || result.motion == MotionKind::arc)
      prepare_insertion(result, move, before, frame.values);
    result.external = {values.begin() + 6, values.end()};
    if (!is_axes) {
      result.has_orientation = values.segment<3>(3).array().isFinite().all();
      if (!result.has_orientation) result.pose.translation = position(values);
      result.configuration = configuration_of(frame);
      const bool is_straight = move.motion != KrlMotion::point_to_point;
      const bool is_on_branch = result.motion == MotionKind::arc || starts_.follows(index);
      result.configuration.continues = is_straight && is_on_branch;
      result.configuration.is_weak = is_straight && !is_on_branch;
    }
    add_target_at(std::move(result), point);
  }

  // With other values for what it leaves out, a declaration is another point.
  int point_for(const KrlTarget& target, const KrlFrame& frame, const KrlValues& values,
                bool is_auxiliary) {
    const bool is_axes = target.kind == KrlTargetKind::axes;
    int& point = is_axes ? point_of_axes_[target.axes] : point_of_frame_[target.frame];
    const bool is_another = point >= 0 && !is_axes && !states(point, values, is_auxiliary);
    if (point >= 0 && !is_another) return point;
    if (is_another) program_.points[point].is_shared = true;
    point = add_point(target, frame, values, is_auxiliary);
    program_.points.back().is_shared |= is_another;
    return point;
  }

  // Whether a point has these values, also where they are not written.
  bool states(int point, const KrlValues& values, bool is_auxiliary) const {
    const std::vector<ProgramNumber>& numbers = program_.points[point].numbers;
    for (size_t i = 0; i < 6; ++i) {
      if (numbers[i].is_written()) continue;
      if (numbers[i].prefix.empty() != (is_auxiliary && i > 2)) return false;
      const double value = values[i] / unit_of(i);
      const bool is_unknown = std::isnan(value) && std::isnan(numbers[i].value);
      if (numbers[i].value != value && !is_unknown) return false;
    }
    return true;
  }

  static double unit_of(size_t number) { return number < 3 ? kMillimetre : kDegree; }

  // Where the name of a point stands in the move, its name.
  std::string name_of(const KrlTarget& target, const KrlFrame& frame, int line) const {
    const std::string& src = program_.texts[0].text;
    if (frame.text > 0 || src[target.begin] != '{')
      return src.substr(target.begin, target.end - target.begin);
    return fmt::format("the point of line {}", counted_line(line));
  }

  int add_point(const KrlTarget& target, const KrlFrame& frame, const KrlValues& values,
                bool is_auxiliary) {
    ProgramPoint point;
    const int text = frame.text;
    point.line = line_of(text, frame.begin);
    point.name = name_of(target, frame, point.line);
    point.text = text;
    point.begin = frame.begin;
    point.end = frame.end;
    point.is_shared = target.shared;
    point.is_of_others = target.is_global || static_cast<size_t>(text) >= program_.own_texts;
    point.is_expression = target.is_expression;
    if (point.is_expression) {
      point.before = target.before;
      point.behind = target.behind;
      const bool is_axes = target.kind == KrlTargetKind::axes;
      const auto number = [&](double value, const std::string& prefix) {
        return ProgramNumber{text, frame.end, frame.end, value, prefix};
      };
      if (is_axes) point.kind = TargetKind::joints;
      for (size_t i = 0; i < 6; ++i)
        point.numbers.push_back(number(is_axes ? frame.axes[i] : values[i] / unit_of(i), ""));
      if (frame.turn && frame.status)
        point.configuration = {number(*frame.turn, ""), number(*frame.status, "")};
      for (int i = 6; i < kKrlComponents; ++i) {
        const bool is_stated = std::isfinite(frame.values[i]);
        point.external.push_back(number(values[i], is_stated ? fmt::format(",E{} ", i - 5) : ""));
      }
      if (target.starts_from >= 0)
        starts_of_points_.emplace_back(program_.points.size(), target.starts_from);
      return keep(point, is_axes ? -1 : target.frame);
    }
    const auto place = [&](const KrlFrame::Number& number) {
      return ProgramNumber{text, frame.begin + number.begin, frame.begin + number.end, 0, ""};
    };
    add_external(frame, place, point);
    if (target.kind == KrlTargetKind::axes) {
      point.kind = TargetKind::joints;
      for (size_t i = 0; i < 6; ++i)
        point.numbers.emplace_back(place(frame.axis_numbers[i])).value = frame.axes[i];
      return keep(point, -1);
    }
    const auto behind = [&](size_t count) {  // the first numbers that are written
      size_t end = 0;
      for (size_t i = 0; i < count; ++i) end = std::max<size_t>(end, frame.numbers[i].end);
      return frame.begin + end;
    };
    for (size_t i = 0; i < 6; ++i) {
      ProgramNumber& number = point.numbers.emplace_back(place(frame.numbers[i]));
      number.value = values[i] / unit_of(i);
      if (frame.numbers[i].end > 0) continue;
      number.begin = number.end = behind(i < 3 && behind(3) > frame.begin ? 3 : 6);
      // The orientation of an auxiliary point counts for nothing.
      if (!is_auxiliary || i < 3) number.prefix = fmt::format(",{} ", kPoseNames[i]);
    }
    point.configuration = {place(frame.turn_number), place(frame.status_number)};
    point.configuration[0].value = frame.turn.value_or(0);
    point.configuration[1].value = frame.status.value_or(0);
    return keep(point, target.frame);
  }

  // E1 to E6; where one is not written, behind all numbers.
  template <class Place>
  static void add_external(const KrlFrame& frame, Place place, ProgramPoint& point) {
    size_t behind = 0;
    for (const KrlFrame::Number& number : frame.numbers)
      behind = std::max<size_t>(behind, number.end);
    for (const KrlFrame::Number& number : frame.axis_numbers)
      behind = std::max<size_t>(behind, number.end);
    for (size_t i = 6; i < kKrlComponents; ++i) {
      ProgramNumber& number = point.external.emplace_back(place(frame.numbers[i]));
      number.value = frame.values[i];
      if (number.is_written()) continue;
      number.begin = number.end = frame.begin + behind;
      number.prefix = fmt::format(",E{} ", i - 5);
    }
  }

  // Counts on from the last place: points mostly come in their order.
  int line_of(int text, size_t at) {
    const std::string& whole = program_.texts[text].text;
    auto& [place, line] = counted_[text];
    if (at < place) {
      place = 0;
      line = 1;
    }
    for (; place < at; ++place) line += whole[place] == '\n';
    return line;
  }

  int keep(const ProgramPoint& point, int frame) {
    program_.points.push_back(point);
    frame_of_point_.push_back(frame);
    return static_cast<int>(program_.points.size()) - 1;
  }

  void find_names() {
    for (size_t i = 0; i < program_.own_texts; ++i) {
      for (const Statement& line : lines_of(program_.texts[i].text)) {
        const auto head = krl_head(program_.texts[i].text, line);
        if (!head || head->name.empty() || begins_krl_routine(head->word) != (i == 0)) continue;
        program_.names.push_back({static_cast<int>(i), head->begin, head->end});
        break;
      }
    }
  }

  const KrlSyntax& syntax_;
  const KnownFrames& known_;
  const TargetParts parts_;
  ProgramWarnings unused_;  // of frames, where positions count as they stand
  const KrlSetUps::List set_ups_;
  const KrlStarts starts_;
  const KrlZones zones_;
  std::vector<int> end_of_move_;  // its target; -1: left alone
  std::vector<size_t> move_of_target_;
  std::vector<int> point_of_frame_, point_of_axes_;
  std::vector<int> frame_of_point_;                       // -1: joint angles
  std::vector<std::pair<size_t, int>> starts_of_points_;  // expressions, and frames of their points
  std::vector<char> runs_;                                // of each move: a way leads to it
  std::vector<char> is_left_alone_;                       // of each frame: a move to it is
  std::vector<std::pair<size_t, int>> counted_;           // of each text: place, line
};

}  // namespace

void parse_krl_program(RobotProgram& program, const KnownFrames& known, TargetParts parts) {
  const KrlSyntax syntax = parse_krl(program);
  KrlReader(program, syntax, known, parts).read();
}

}  // namespace armtrue
