#include <algorithm>

#include "armtrue/compensation/program_findings.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/compensation_io.h"
#include "armtrue/report/compensation_page.h"
#include "correction_inputs.h"
#include "target_correction.h"

using namespace armtrue;

namespace {

void refuse_options_of_tables(const app::Command& command,
                              const app::CorrectionArguments& arguments) {
  if (!arguments.commands.empty())
    throw app::UsageError("--commands: the targets of a program stay of their kind; leave it out");
  if (command.output != "-")
    throw app::UsageError("-o: a program goes to --program-out, and there is no other product");
}

// The targets of a table, or those of a program.
struct Task {
  std::optional<RobotProgram> program;
  ProgramJoints joints;
  ProgramFile file;
};

Task read_task(app::Command& command, const Robot& controller,
               const app::CorrectionArguments& arguments) {
  Task task;
  if (arguments.program.path.empty()) {
    task.file = command.read_program(command.input, controller);
    return task;
  }
  refuse_options_of_tables(command, arguments);
  const RobotProgram& program =
      task.program.emplace(app::read_robot_program(command, arguments.program));
  refuse_two_tools(program, arguments.tool_is_measured);
  app::refuse_overruled_frames(program, arguments);
  task.file.source = program.texts[0].name;
  task.joints = joints_of_program(program, controller, arguments.controller);
  return task;
}

int run(app::Command& command, app::CorrectionArguments& arguments) {
  const app::Models models = app::read_models(command, arguments);
  const Robot &robot = models.robot, &controller = models.controller;
  const std::optional<About> about = app::read_about(command, arguments.page);
  app::refuse_other_files(robot, controller, arguments);
  if (!arguments.project.folder.empty()) return app::correct_folder(command, models, arguments);
  if (!arguments.program.frames.empty() && arguments.program.path.empty())
    throw app::UsageError("--frame: is for --program or --project");
  auto [read, joints, file] = read_task(command, controller, arguments);
  RobotProgram* const program = read ? &*read : nullptr;
  DividedProgram divided = app::correct(command, models, program, joints, file, arguments);
  std::vector<CorrectedTarget>& targets = divided.targets;

  PredictionConditions conditions{robot.name, controller.name,
                                  app::assumptions(controller, program, arguments),
                                  station_effects(robot, arguments.tool_is_measured)};
  std::optional<BetweenPoints> between;
  if (arguments.spacing_mm) between = divided.between;
  const std::vector<std::string> in_doubt =
      app::doubts_of_commands(models, targets, file.program.visits, arguments);
  app::warn_of_doubts(command, in_doubt, conditions);
  app::warn_of_station(command, conditions.not_applied);
  bool is_followed = true;
  if (program)
    is_followed = app::write_robot_program(
        command, *program,
        program_commands(*program, file.program, targets, joints, controller,
                         app::compensation_options(arguments, controller)),
        divided.inserted, arguments.program);
  else
    write_output(command.output,
                 write_commands(file, targets, app::command_kind(arguments, file.program)));
  bool is_whole = std::ranges::all_of(targets, &CorrectedTarget::is_corrected);
  if (program) {
    const CorrectedMoves moves = corrected_moves(*program, targets);
    is_whole = conditions.all_moves = moves.corrected == moves.all;
    conditions.moves = moves.sentence;
  }
  app::warn_of_all(command, sentences_of_notes(targets, file.program.visits, file.source));
  for (const std::string& left :
       sentences_of_moves(divided.between, file.program.visits, file.source)) {
    command.warn(left);
    is_followed = false;
  }
  const Document product =
      write_compensation(targets, file.program, between, conditions, command.provenance());
  if (!arguments.summary.empty()) write_output(arguments.summary, product);
  command.report((program ? file.source + ": " + conditions.moves + "\n" : "") +
                 compensation_table(targets, file.program) + "Programs need " + kFramesNeeded +
                 "\n");
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      compensation_page(targets, file.program, between, conditions,
                                        app::page_head(command, product, about)));
  const bool is_strict = !app::is_noted(targets) && is_followed && in_doubt.empty();
  return (arguments.strict && !is_strict) || (arguments.require_all && !is_whole)
             ? app::kNotReached
             : app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command(
      "compensate", "Commands that make an identified arm reach the targets of a program.",
      "compensate --robot closed.yaml --controller nominal.yaml targets.csv "
      "-o commands.csv\n  compensate --robot closed.yaml --controller nominal.yaml "
      "--program part.src --program-out new/part.src");
  app::CorrectionArguments arguments;
  app::add_correction_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
