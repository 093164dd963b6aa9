#include "armtrue/compensation/target_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"

namespace armtrue {
namespace {

// The flange is no tool, and no tool reaches as little beyond it.
constexpr double kShortestTool = 1e-3;  // m
constexpr double kNearestFrame = 0.01;  // m, from R_0 where it is not R_0: 10 m in m
constexpr double kSmallestPart = 3e-3;  // m, about the origin of its frame: a part of 3 m in m

std::vector<double> values_of(const ProgramPoint& point) {
  std::vector<double> values;
  for (const ProgramNumber& number : point.numbers) values.push_back(number.value);
  for (size_t i = 0; i < point.counts_per_unit.size(); ++i) values[i] /= point.counts_per_unit[i];
  return values;
}

double largest_of(std::span<const double> values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

// Angles that are read as degrees. A posture bends three joints or more, and people write degrees
// near the zero posture as whole or half ones.
bool looks_like_radians(std::span<const double> degrees) {
  constexpr std::ptrdiff_t kBent = 3;
  constexpr double kHalf = 2, kExact = 1e-6;
  const auto is_fraction = [](double value) {
    return std::abs(value * kHalf - std::round(value * kHalf)) > kExact;
  };
  return largest_of(degrees) < kTurn && std::ranges::count_if(degrees, is_fraction) >= kBent;
}

// `farthest`: the largest coordinate [m].
std::string doubt_of_metres(const std::string& file, int line, int points, double farthest) {
  return fmt::format(
      "{}:{}: all {} points lie within {:.3g} mm of the origin of their frame: are they in m? "
      "Its controller counts mm",
      file, line, points, farthest / kMillimetre);
}

bool counts_radians(const RobotProgram& program) { return program.dialect->facts().angle == 1; }

void check_joints(const RobotProgram& program, std::vector<std::string>& doubts) {
  constexpr double kMostTurns = 2;  // of a joint of UR, the one that counts rad
  const std::string& file = program.texts[0].name;
  const ProgramTarget* small = nullptr;
  double most = 0;
  for (const ProgramTarget& target : program.targets) {
    if (target.kind != TargetKind::joints) continue;
    const std::vector<double> values = values_of(program.points[target.point]);
    const double largest = largest_of(values);
    most = std::max(most, largest);
    if (counts_radians(program)) {
      if (largest < kMostTurns * kTurn) continue;
      doubts.push_back(fmt::format(
          "{}:{}: a joint angle of {:g} rad is {:.3g} turns: are these degrees? A {} counts rad",
          file, target.line, largest, largest / kTurn, program.dialect->facts().maker));
      return;
    }
    if (!small && looks_like_radians(values)) small = &target;
  }
  if (small && most < kTurn)
    doubts.push_back(fmt::format(
        "{}:{}: all joint angles of the program lie within {:.3g} deg of zero: are these radians? "
        "Its controller counts degrees",
        file, small->line, most));
}

void check_points(const RobotProgram& program, std::vector<std::string>& doubts) {
  const std::string& file = program.texts[0].name;
  double farthest = 0;
  int points = 0, line = 0;
  for (const ProgramTarget& target : program.targets) {
    if (target.kind != TargetKind::cartesian) continue;
    if (counts_radians(program)) {
      const std::vector<double> values = values_of(program.points[target.point]);
      const double turn = std::hypot(values[3], values[4], values[5]);
      if (turn <= kTurn) continue;
      doubts.push_back(fmt::format(
          "{}:{}: the rotation vector is {:.4g} rad long, more than a turn: are these degrees? A "
          "{} counts rad",
          file, target.line, turn, program.dialect->facts().maker));
      return;
    }
    if (points++ == 0) line = target.line;
    farthest = std::max(farthest, target.pose.translation.cwiseAbs().maxCoeff());
  }
  if (points > 1 && farthest > 0 && farthest < kSmallestPart)
    doubts.push_back(doubt_of_metres(file, line, points, farthest));
}

void check_frames(const RobotProgram& program, const CompensationOptions& options, bool has_tool,
                  std::vector<std::string>& doubts) {
  const std::string& file = program.texts[0].name;
  std::vector<bool> is_tool(program.frames.size()), is_base(program.frames.size());
  const ProgramTarget* without = nullptr;
  for (const ProgramTarget& target : program.targets) {
    if (target.base >= 0) is_base[target.base] = true;
    if (target.tool >= 0)
      is_tool[target.tool] = true;
    else if (!without && target.kind == TargetKind::cartesian)
      without = &target;
  }
  for (size_t k = 0; k < is_tool.size(); ++k) {
    const ProgramFrame& frame = program.frames[k];
    if (!frame.is_known || !(is_tool[k] || is_base[k])) continue;
    const std::string doubt =
        is_tool[k] ? doubt_of_tool(frame.name, frame.pose) : doubt_of_frame(frame.name, frame.pose);
    if (!doubt.empty()) doubts.push_back(file + ": " + doubt);
  }
  if (!without || has_tool || options.tool_is_measured) return;
  if (const std::string& setting = program.dialect->facts().sets_active_tool; !setting.empty())
    doubts.push_back(fmt::format(
        "{}:{}: no {} stands before this move, and the controller takes the tool that is active "
        "then; the commands hold for the flange alone. Give --tool=x,y,z,a,b,c (--tool=0,0,0,0,0,0 "
        "if it is the flange)",
        file, without->line, setting));
}

void check_calls(const RobotProgram& program, std::vector<std::string>& doubts) {
  if (program.calls_not_given.empty()) return;
  constexpr size_t kShown = 3;
  std::vector<std::string> names;
  for (const ProgramCall& call : program.calls_not_given)
    if (std::ranges::find(names, call.routine) == names.end()) names.push_back(call.routine);
  std::string listed;
  for (size_t k = 0; k < std::min(kShown, names.size()); ++k)
    listed += (k == 0 ? "" : ", ") + names[k];
  if (names.size() > kShown) listed += fmt::format(" and {} more", names.size() - kShown);
  const DialectFacts& facts = program.dialect->facts();
  doubts.push_back(fmt::format(
      "{}:{}: no text that is given has {}: if it sets {} or {}, as a change of the tool does, the "
      "moves behind the call are corrected with the wrong ones; give its text (--with)",
      program.texts[0].name, program.calls_not_given.front().line, listed, facts.frame,
      facts.tool));
}

// People write quarters and eighths of a turn: 1.5708 as a number of degrees is one of them in rad.
std::string doubt_of_turn(const std::string& name, const Pose& pose) {
  constexpr double kEighth = std::numbers::pi / 4, kRounding = 5e-3;  // 1.57
  const Eigen::Vector3d degrees = abc_from_rotation(pose.rotation) / kDegree;
  for (const double angle : degrees) {
    const double eighths = std::round(std::abs(angle) / kEighth);
    if (eighths >= 1 && eighths <= 4 && std::abs(std::abs(angle) - eighths * kEighth) < kRounding)
      return fmt::format("{} is turned by {:.6g} deg, which is {:g} deg in rad: is it in rad?",
                         name, angle, eighths * 45);
  }
  return "";
}

}  // namespace

std::string doubt_of_joints(const std::string& option, const std::vector<double>& degrees) {
  if (!looks_like_radians(degrees)) return "";
  return fmt::format(
      "{}: all joint angles lie within {:.3g} deg of zero: are these radians? Give degrees", option,
      largest_of(degrees));
}

std::string doubt_of_tool(const std::string& name, const Pose& tool) {
  if (std::string doubt = doubt_of_turn("the tool " + name, tool); !doubt.empty()) return doubt;
  const double length = tool.translation.norm();
  if (length == 0 || length >= kShortestTool) return "";
  return fmt::format(
      "the tool {} ends {:.3g} mm from the flange: is it in m? Give it in mm", name,
      length / kMillimetre);
}

std::string doubt_of_frame(const std::string& name, const Pose& frame) {
  if (std::string doubt = doubt_of_turn("the frame " + name, frame); !doubt.empty()) return doubt;
  const double away = frame.translation.norm();
  constexpr double kNothing = 1e-3 * kMillimetre;  // what products of frames leave
  if (away < kNothing || away >= kNearestFrame) return "";
  return fmt::format("the frame {} stands {:.3g} mm from R_0: is it in m? Give it in mm", name,
                     away / kMillimetre);
}

std::vector<std::string> doubts_of_program(const RobotProgram& program,
                                           const CompensationOptions& options, bool has_tool) {
  std::vector<std::string> doubts;
  check_joints(program, doubts);
  check_points(program, doubts);
  check_frames(program, options, has_tool, doubts);
  check_calls(program, doubts);
  return doubts;
}

std::string doubt_of_table(const std::string& file, const Program& program) {
  double farthest = 0;
  for (const Pose& pose : program.poses)
    farthest = std::max(farthest, pose.translation.cwiseAbs().maxCoeff());
  if (program.poses.size() < 2 || farthest == 0 || farthest >= kSmallestPart) return "";
  return doubt_of_metres(file, program.visits.line.front(),
                         static_cast<int>(program.poses.size()), farthest);
}

}  // namespace armtrue
