#include "correction_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/dialect.h"
#include "columns.h"

namespace armtrue::app {
namespace {

constexpr double kSamePlace = 1e-6, kSameTurn = 1e-6;  // m, rad: rounding of a text

// The tools or frames that the program names.
StatedFrames stated_frames(const RobotProgram* program, int ProgramTarget::*frame) {
  StatedFrames stated;
  if (!program) return stated;
  std::set<std::string> names;
  for (const ProgramTarget& target : program->targets)
    if (target.*frame >= 0) names.insert(program->frames[target.*frame].name);
  stated.names.assign(names.begin(), names.end());
  stated.everywhere = std::ranges::none_of(
      program->targets, [&](const ProgramTarget& target) { return target.*frame < 0; });
  stated.in_base = program->dialect->facts().has_frames_in_base && frame == &ProgramTarget::base;
  return stated;
}

// An option that every target of a program overrules, with another value, was meant to count.
void refuse_overruled(const char* option, const std::vector<double>& numbers,
                      const RobotProgram& program, int ProgramTarget::*frame) {
  const StatedFrames stated = stated_frames(&program, frame);
  if (numbers.empty() || program.targets.empty() || !stated.everywhere || stated.in_base) return;
  const Pose given = pose_from_numbers(numbers);
  const bool is_stated = std::ranges::any_of(program.targets, [&](const ProgramTarget& target) {
    const Pose& own = program.frames[target.*frame].pose;
    return (own.translation - given.translation).norm() < kSamePlace &&
           (own.rotation - given.rotation).norm() < kSameTurn;
  });
  if (!is_stated)
    throw UsageError(fmt::format(
        "{0}: every move of {1} has its own ({2}), so {0} would change nothing; leave it out, or "
        "change the program",
        option, program.texts[0].name, fmt::join(stated.names, ", ")));
}

}  // namespace

void refuse_overruled_frames(const RobotProgram& program, const ProgramArguments& arguments) {
  refuse_overruled("--tool", arguments.tool, program, &ProgramTarget::tool);
  refuse_overruled("--base", arguments.base, program, &ProgramTarget::base);
}

void add_correction_options(Command& command, CorrectionArguments& arguments) {
  command.add_input("Targets of a program, in its order");
  command.add_output(ProductKind::table);
  add_models(command, arguments);
  add_frames(command, arguments);
  command
      .option("--commands", arguments.commands,
              "Kind of the commands: joints, or cartesian (the pose of the controller's model at "
              "these joints); that of the targets if absent")
      .check(one_of({"joints", "cartesian"}));
  command.joints("--start", arguments.start,
                 "Joint angles q1,...,q6 in deg (lengths in mm) near the first Cartesian target, "
                 "if it has none");
  add_conditions(command, arguments);
  command
      .option("--max-mm", arguments.max_mm,
              "Targets that need a larger correction are left as programmed")
      .check(above_zero())
      .default_shown();
  command
      .option("--uncovered", arguments.uncovered,
              "Targets that the readings do not cover (notes outside-readings and below-std): keep "
              "their corrections, or leave them as programmed")
      .check(one_of({"keep", "leave"}))
      .default_shown();
  command.flag("--move-external-axes", arguments.move_external_axes,
               "The correction may move E1 to E6, such as a rail, too; they stay as programmed if "
               "absent");
  const Option program = add_robot_program(command, arguments.program);
  add_project(command, arguments.project);
  command
      .option(
          "--spacing-mm", arguments.spacing_mm,
          "Divide moves of the program, straight and circular, until the predicted error between "
          "two points is below this")
      .check(above_zero())
      .needs(program);
  command.add_output("--summary", arguments.summary,
                     "Write counts, errors and the worst targets here", ProductKind::document);
  add_report(command, arguments.page, "with errors before and after, notes and a map");
  command.flag("--strict", arguments.strict,
               "Exit with 3 if a target has a note, or an assumption is in doubt");
  command.flag("--require-all", arguments.require_all,
               "Exit with 3 if a move of the program, or a target of a table, is not corrected");
  command.add_columns(kProgramColumns);
}

CompensationOptions compensation_options(const CorrectionArguments& arguments, const Robot& robot) {
  CompensationOptions options = program_options(arguments, robot);
  options.move_external_axes = arguments.move_external_axes;
  options.max_correction = arguments.max_mm * kMillimetre;
  options.correct_uncovered = arguments.uncovered == "keep";
  if (!options.start) options.start = arguments.posture_of_calls;
  return options;
}

CommandKind command_kind(const CorrectionArguments& arguments, const Program& program) {
  if (arguments.commands.empty())
    return program.is_cartesian() ? CommandKind::cartesian : CommandKind::joints;
  return arguments.commands == "joints" ? CommandKind::joints : CommandKind::cartesian;
}

std::vector<std::string> assumptions(const Robot& controller, const RobotProgram* program,
                                     const CorrectionArguments& arguments) {
  return {
      fmt::format(
          "The controller runs {} and nothing else. If a calibrated model is active in it (KUKA "
          "absolute accuracy, ABB AbsAcc, UR calibration.conf), that is --controller; otherwise "
          "the program is corrected twice.",
          arguments.controller),
      assumed_frames(controller, arguments, stated_frames(program, &ProgramTarget::tool),
                     stated_frames(program, &ProgramTarget::base))};
}

}  // namespace armtrue::app
