#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/krl.h"
#include "programs/dialects.h"
#include "programs/krl_set_up.h"
#include "programs/krl_syntax.h"
#include "programs/krl_words.h"
#include "programs/program_values.h"
#include "programs/program_warnings.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

// Programs of KUKA controllers: KSS 8.x, operating and programming instructions for system
// integrators, chapters "Motion programming" and "Status and Turn".

namespace armtrue {
namespace {

constexpr const char* kPoseNames[] = {"X", "Y", "Z", "A", "B", "C"};

const char* reason_of(KrlTargetKind kind) {
  switch (kind) {
    case KrlTargetKind::undeclared:
      return "its point is not declared here; give the .dat with it, or correct it where it is";
    case KrlTargetKind::reassigned:
      return "its point is given several values, or changed at run time";
    case KrlTargetKind::frame:
    case KrlTargetKind::axes:
    case KrlTargetKind::expression:
      break;
  }
  return "its target is an expression or has no plain numbers";
}

// S and T. Bit 0 of S: the wrist lies behind axis 1; bit 1: the forearm is bent to the side of
// A3 = 90 deg; bit 2: A5 is below zero. T says the last one too, and more surely. Bits of T: joints
// below zero.
Configuration configuration_of(const KrlFrame& frame, bool is_straight) {
  Configuration result;
  result.reference << 0, -90, 90, 0, 45, 0;
  result.reference *= kDegree;
  result.continues = is_straight;
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

class KrlReader {
 public:
  KrlReader(RobotProgram& program, const KrlProgram& texts, const KrlSyntax& syntax,
            const KnownFrames& known)
      : program_(program),
        syntax_(syntax),
        warnings_(texts.src.name),
        set_ups_(texts, syntax, known, program.frames, warnings_),
        point_of_frame_(syntax.frames.size(), -1),
        point_of_axes_(syntax.axes.size(), -1) {}

  void read() {
    if (syntax_.absolute_accuracy_line > 0)
      warnings_.add(syntax_.absolute_accuracy_line,
                    "$ABS_ACCUR: where absolute accuracy is active, the controller runs the model "
                    "that KUKA measured, and that is --controller");
    for (const KrlMove& move : syntax_.moves) read_move(move);
    find_names();
    program_.warnings = warnings_.list();
  }

 private:
  void leave(const KrlMove& move, const std::string& reason) {
    warnings_.add(move.line, "left alone: " + reason);
    ++program_.left_alone;
    before_ = unknown_krl_values();
    is_posture_known_ = is_target_known_ = false;
  }

  void read_move(const KrlMove& move) {
    const KrlSetUps::SetUp set_up = set_ups_.at(move);
    if (move.relative)
      return leave(move, "a relative move; it starts from the corrected point before it");
    if (set_up.is_external_tcp)
      return leave(move, "its tool stands in the room (#TCP), and the robot holds the part");
    const bool is_circle = move.motion == KrlMotion::circle;
    for (const KrlTarget* target : {&move.auxiliary, &move.target}) {
      if (target == &move.auxiliary && !is_circle) continue;
      if (target->kind != KrlTargetKind::frame && target->kind != KrlTargetKind::axes)
        return leave(move, reason_of(target->kind));
    }
    if (move.circle_angle)
      warnings_.add(move.line,
                    "a circle with an angle does not end at its target; its points are corrected");
    if (is_circle && !read_target(move, move.auxiliary, set_up, true)) return;
    if (!read_target(move, move.target, set_up, false)) return;
    is_target_known_ = !move.circle_angle;
  }

  // Fills what stands beside the point of an inserted move.
  void prepare_insertion(ProgramTarget& target, const KrlMove& move,
                         const KrlValues& values) const {
    if (syntax_.circles_turn_with_path && target.motion == MotionKind::arc)
      target.obstacle = "$CIRC_TYPE is #PATH in this program";
    if (move.circle_angle) target.obstacle = "its angle says where it ends";
    if (move.in_spline_block) target.obstacle = "it stands in a spline block";
    if (move.after_trigger) target.obstacle = "a TRIGGER refers to it";
    if (target.kind == TargetKind::joints ||
        (target.motion == MotionKind::arc && move.auxiliary.kind == KrlTargetKind::axes))
      target.obstacle = "its point is joint angles";
    for (int k = 6; k < kKrlComponents; ++k)
      if (std::isfinite(values[k]) && values[k] != before_[k])
        target.obstacle = "external axes move, or the point before does not state them";
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
    if (is_arc) {
      beside.middle = src.substr(first.end, move.target.begin - first.end);
      beside.via_begin = first.begin;
      beside.via_end = first.end;
    }
    if (move.in_inline_form)
      target.insertion.remark =
          "points are inserted in an inline form; changing it on the pendant drops them";
  }

  static MotionKind motion_of(const KrlMove& move, bool is_auxiliary) {
    switch (move.motion) {
      case KrlMotion::point_to_point:
      case KrlMotion::spline_point:
        break;
      case KrlMotion::line:
        return MotionKind::line;
      case KrlMotion::circle:
        return is_auxiliary ? MotionKind::via : MotionKind::arc;
    }
    return MotionKind::joint;
  }

  bool read_target(const KrlMove& move, const KrlTarget& target, const KrlSetUps::SetUp& set_up,
                   bool is_auxiliary) {
    const bool is_axes = target.kind == KrlTargetKind::axes;
    const KrlFrame& frame = is_axes ? syntax_.axes[static_cast<size_t>(target.axes)]
                                    : syntax_.frames[static_cast<size_t>(target.frame)];
    ProgramTarget result;
    result.line = move.line;
    result.base = set_up.base;
    result.tool = set_up.tool;
    result.kind = is_axes ? TargetKind::joints : TargetKind::cartesian;
    result.motion = motion_of(move, is_auxiliary);
    result.follows_target = result.motion == MotionKind::arc
                                ? !move.circle_angle && !syntax_.circles_turn_with_path
                                : move.follows_move && is_target_known_;
    int& point = is_axes ? point_of_axes_[static_cast<size_t>(target.axes)]
                         : point_of_frame_[static_cast<size_t>(target.frame)];
    const bool is_new = point < 0;
    const KrlValues values = inherit(before_, frame.values);
    if (is_axes) {
      for (double angle : frame.axes)
        if (!std::isfinite(angle)) {
          leave(move, "joint angles that are not six plain numbers");
          return false;
        }
    } else if (!values.head<6>().array().isFinite().all()) {
      leave(move, "X, Y, Z, A, B, C are not all stated, and the move before does not state them");
      return false;
    } else if (!is_new && !frame.values.head<6>().array().isFinite().all()) {
      leave(move, "a point that leaves out coordinates and is used by several moves");
      return false;
    }
    if (target.shared && is_new)
      warnings_.add(move.line,
                    "other statements or files use its point too, and see the corrected one");
    if (is_new) point = add_point(target, frame, values, is_auxiliary);
    result.point = point;
    if (result.motion == MotionKind::line || result.motion == MotionKind::arc)
      prepare_insertion(result, move, values);
    const std::vector<double> numbers = values_of(point);
    if (is_axes) {
      result.q = joints_of_numbers(Dialect::krl, numbers);
      before_ = unknown_krl_values();
    } else {
      result.pose = pose_of_numbers(Dialect::krl, numbers);
      const bool is_straight = is_auxiliary || move.motion != KrlMotion::point_to_point;
      result.configuration = configuration_of(frame, is_straight && is_posture_known_);
      note_external_axes(move, values);
      if (!is_auxiliary) before_ = values;
    }
    program_.targets.push_back(result);
    is_posture_known_ = true;
    return true;
  }

  std::vector<double> values_of(int point) const {
    std::vector<double> values;
    for (const ProgramNumber& number : program_.points[static_cast<size_t>(point)].numbers)
      values.push_back(number.value);
    return values;
  }

  // Where the name of a point stands in the move, its name.
  std::string name_of(const KrlTarget& target, const KrlFrame& frame, int line) const {
    const std::string& src = program_.texts[0].text;
    if (frame.in_dat || src[target.begin] != '{')
      return src.substr(target.begin, target.end - target.begin);
    return fmt::format("the point of line {}", line);
  }

  int add_point(const KrlTarget& target, const KrlFrame& frame, const KrlValues& values,
                bool is_auxiliary) {
    ProgramPoint point;
    const int text = frame.in_dat ? 1 : 0;
    point.line = line_of(text, frame.begin);
    point.name = name_of(target, frame, point.line);
    const auto place = [&](const KrlFrame::Number& number) {
      return ProgramNumber{text, frame.begin + number.begin, frame.begin + number.end, 0, ""};
    };
    if (target.kind == KrlTargetKind::axes) {
      point.kind = TargetKind::joints;
      for (size_t i = 0; i < 6; ++i)
        point.numbers.emplace_back(place(frame.axis_numbers[i])).value = frame.axes[i];
      return keep(point);
    }
    size_t behind = frame.entries;  // all numbers that are written
    for (size_t i = 0; i < 6; ++i) behind = std::max(behind, frame.begin + frame.numbers[i].end);
    for (size_t i = 0; i < 6; ++i) {
      ProgramNumber& number = point.numbers.emplace_back(place(frame.numbers[i]));
      number.value = values[static_cast<int>(i)] / (i < 3 ? kMillimetre : kDegree);
      if (frame.numbers[i].end > 0) continue;
      number.begin = number.end = behind;
      // The orientation of an auxiliary point counts for nothing.
      if (!is_auxiliary || i < 3) number.prefix = fmt::format(",{} ", kPoseNames[i]);
    }
    if (frame.turn) point.configuration.emplace_back(place(frame.turn_number)).value = *frame.turn;
    return keep(point);
  }

  // Counts on from the last place: points mostly come in their order.
  int line_of(int text, size_t at) {
    const std::string& whole = program_.texts[static_cast<size_t>(text)].text;
    auto& [place, line] = counted_[static_cast<size_t>(text)];
    if (at < place) {
      place = 0;
      line = 1;
    }
    for (; place < at; ++place) line += whole[place] == '\n';
    return line;
  }

  int keep(const ProgramPoint& point) {
    program_.points.push_back(point);
    return static_cast<int>(program_.points.size()) - 1;
  }

  void note_external_axes(const KrlMove& move, const KrlValues& values) {
    for (int k = 6; k < kKrlComponents; ++k) {
      if (!std::isfinite(values[k])) continue;
      double& first = external_[k];
      if (std::isnan(first)) first = values[k];
      if (first == values[k] || warned_of_external_) continue;
      warnings_.add(move.line,
                    "external axes move and are left alone; if they move the robot or the part, "
                    "--base and the frames hold for one place of them only");
      warned_of_external_ = true;
    }
  }

  void find_names() {
    for (size_t i = 0; i < program_.texts.size(); ++i) {
      const std::string& text = program_.texts[i].text;
      const std::string wanted = i == 0 ? "DEF" : "DEFDAT";
      for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        TextCursor cursor(text, begin, end);
        std::string word = cursor.take_name();
        if (word == "GLOBAL") word = cursor.take_name();
        begin = end + 1;
        if (word != wanted) continue;
        cursor.next();
        const size_t name = cursor.at();
        if (cursor.take_name().empty()) continue;
        program_.names.push_back({static_cast<int>(i), name, cursor.at()});
        break;
      }
    }
  }

  RobotProgram& program_;
  const KrlSyntax& syntax_;
  ProgramWarnings warnings_;
  KrlSetUps set_ups_;
  std::vector<int> point_of_frame_, point_of_axes_;
  KrlValues before_ = unknown_krl_values();  // the end of the move before, as programmed
  KrlValues external_ = unknown_krl_values();
  bool warned_of_external_ = false;
  bool is_posture_known_ = true;  // no move was left alone since the last target
  bool is_target_known_ = false;  // the move before ends at a target
  std::array<std::pair<size_t, int>, 2> counted_{{{0, 1}, {0, 1}}};  // of each text: place, line
};

}  // namespace

void parse_krl_program(RobotProgram& program, const KnownFrames& known) {
  KrlProgram texts{program.texts[0], std::nullopt};
  if (program.texts.size() > 1) texts.dat = program.texts[1];
  const KrlSyntax syntax = parse_krl(texts);
  KrlReader(program, texts, syntax, known).read();
}

}  // namespace armtrue
