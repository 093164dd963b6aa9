#include "armtrue/compensation/program_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

Pose frame_of(const RobotProgram& program, const ProgramTarget& target, bool is_tool,
              const Pose& otherwise) {
  const int index = is_tool ? target.tool : target.base;
  if (index < 0) return otherwise;
  const ProgramFrame& frame = program.frames[static_cast<size_t>(index)];
  if (frame.is_known || target.kind == TargetKind::joints) return frame.pose;
  throw InputError(fmt::format(
      "{}:{}: the {} is '{}', and the program does not say where that is; give it: --frame "
      "'{}=x,y,z,a,b,c' in mm and deg",
      program.texts[0].name, target.line, is_tool ? "tool" : "frame", frame.name, frame.name));
}

bool states_turn(const RobotProgram& program, size_t row) {
  const ProgramTarget& target = program.targets[row];
  return program.dialect == Dialect::krl && target.kind == TargetKind::cartesian &&
         !program.points[static_cast<size_t>(target.point)].configuration.empty();
}

}  // namespace

Program program_targets(const RobotProgram& program, const CompensationOptions& options) {
  Program result;
  Campaign& visits = result.visits;
  visits.source = program.texts[0].name;
  const bool is_cartesian = std::ranges::any_of(program.targets, [](const ProgramTarget& target) {
    return target.kind == TargetKind::cartesian;
  });
  std::map<std::pair<int, int>, int> set_ups;
  for (const ProgramTarget& target : program.targets) {
    const bool is_joints = target.kind == TargetKind::joints;
    visits.pose.push_back(visits.rows());
    visits.pose_ids.push_back(fmt::format("line {}", target.line));
    visits.line.push_back(target.line);
    visits.q.push_back(is_joints ? target.q
                                 : target.near.value_or(JointVector::Zero(kProgramAxes)));
    const ProgramSetUp set_up{frame_of(program, target, false, options.base),
                              frame_of(program, target, true, options.tool)};
    const auto [place, is_new] =
        set_ups.try_emplace({target.base, target.tool}, static_cast<int>(result.set_ups.size()));
    if (is_new) result.set_ups.push_back(set_up);
    result.set_up.push_back(place->second);
    if (!is_cartesian) continue;
    result.poses.push_back(target.pose);
    result.joints.push_back(is_joints);
    result.hinted.push_back(target.near.has_value());
    result.configurations.push_back(target.configuration);
  }
  return result;
}

ProgramCommands program_commands(const RobotProgram& program,
                                 std::vector<CorrectedTarget>& targets) {
  ProgramCommands commands;
  if (program.absolute_accuracy_line > 0)
    commands.warnings.push_back(
        fmt::format("{}:{}: $ABS_ACCUR: where absolute accuracy is active, the controller runs the "
                    "model that KUKA measured, and that is --controller",
                    program.texts[0].name, program.absolute_accuracy_line));
  for (size_t row = 0; row < targets.size(); ++row) {
    CorrectedTarget& target = targets[row];
    const ProgramTarget& of_program = program.targets[row];
    if (!states_turn(program, row)) std::erase(target.notes, CommandNote::turn);
    if (program.dialect == Dialect::fanuc && target.is_corrected &&
        of_program.kind == TargetKind::cartesian &&
        !is_in_ranges(of_program.configuration, target.q)) {
      target.is_corrected = false;
      target.q = target.programmed;
      target.pose = target.intended;
      target.after = target.before;
      commands.warnings.push_back(
          fmt::format("{}:{}: left as programmed: the correction would change the turn of a joint, "
                      "which CONFIG states; teach the point with another turn",
                      program.texts[0].name, of_program.line));
    }
    commands.list.push_back({target.is_corrected, target.programmed, target.q, target.pose});
  }
  return commands;
}

}  // namespace armtrue
