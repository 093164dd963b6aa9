#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/corrected_before.h"
#include "armtrue/compensation/move_division.h"
#include "armtrue/compensation/program_findings.h"
#include "armtrue/compensation/program_targets.h"
#include "armtrue/compensation/target_doubts.h"
#include "armtrue/io/output.h"
#include "armtrue/io/products/compensation_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/report/compensation_page.h"
#include "columns.h"
#include "command_line.h"
#include "program_arguments.h"
#include "program_project.h"
#include "report_arguments.h"
#include "robot_program_files.h"

using namespace armtrue;

namespace {

constexpr double kNothing = 1e-9;  // [m]

struct Arguments : app::ProgramArguments {
  std::string commands, summary, uncovered = "keep";
  bool strict = false, require_all = false;
  double max_mm = CompensationOptions{}.max_correction / kMillimetre;
  std::optional<double> spacing_mm;
  bool move_external_axes = false;
  app::RobotProgramFiles program;
  app::ProjectFiles project;
  app::ReportArguments page;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Targets of a program, in its order");
  command.add_output();
  app::add_models(command, arguments);
  app::add_frames(command, arguments);
  command
      .option("--commands", arguments.commands,
              "Kind of the commands: joints, or cartesian (the pose of the controller's model at "
              "these joints); that of the targets if absent")
      .check(app::one_of({"joints", "cartesian"}));
  command.joints("--start", arguments.start,
                 "Joint angles q1,...,q6 in deg (lengths in mm) near the first Cartesian target, "
                 "if it has none");
  app::add_conditions(command, arguments);
  command
      .option("--max-mm", arguments.max_mm,
              "Targets that need a larger correction are left as programmed")
      .check(app::above_zero())
      .default_shown();
  command
      .option("--uncovered", arguments.uncovered,
              "Targets that the readings do not cover (notes outside-readings and below-std): keep "
              "their corrections, or leave them as programmed")
      .check(app::one_of({"keep", "leave"}))
      .default_shown();
  command.flag("--move-external-axes", arguments.move_external_axes,
               "The correction may move E1 to E6, such as a rail, too; they stay as programmed if "
               "absent");
  const app::Option program = app::add_robot_program(command, arguments.program);
  app::add_project(command, arguments.project);
  command
      .option(
          "--spacing-mm", arguments.spacing_mm,
          "Divide moves of the program, straight and circular, until the predicted error between "
          "two points is below this")
      .check(app::above_zero())
      .needs(program);
  command.add_output("--summary", arguments.summary,
                     "Write counts, errors and the worst targets here", app::ProductKind::document);
  app::add_report(command, arguments.page, "with errors before and after, notes and a map");
  command.flag("--strict", arguments.strict,
               "Exit with 3 if a target has a note, or an assumption is in doubt");
  command.flag("--require-all", arguments.require_all,
               "Exit with 3 if a move of the program, or a target of a table, is not corrected");
  command.add_columns(app::kProgramColumns);
}

CompensationOptions compensation_options(const Arguments& arguments, const Robot& robot) {
  CompensationOptions options = app::program_options(arguments, robot);
  options.move_external_axes = arguments.move_external_axes;
  options.max_correction = arguments.max_mm * kMillimetre;
  options.correct_uncovered = arguments.uncovered == "keep";
  return options;
}

// Reasons to doubt the assumptions, in sentences.
std::vector<std::string> doubts(const Robot& robot, const Robot& controller,
                                const std::vector<CorrectedTarget>& targets, const Campaign& visits,
                                const Arguments& arguments) {
  std::vector<std::string> found =
      doubts_of_models(app::pair_of(robot, controller, arguments), visits, "the commands");
  const bool is_nothing = std::ranges::all_of(
      targets, [](const CorrectedTarget& t) { return t.before.position < kNothing; });
  if (is_nothing)
    found.push_back("the controller already runs the model of " + arguments.robot +
                    ": there is nothing to correct");
  return found;
}

// The tools or frames that the program names.
app::StatedFrames stated_frames(const RobotProgram* program, int ProgramTarget::*frame) {
  app::StatedFrames stated;
  if (!program) return stated;
  std::set<std::string> names;
  for (const ProgramTarget& target : program->targets)
    if (target.*frame >= 0) names.insert(program->frames[target.*frame].name);
  stated.names.assign(names.begin(), names.end());
  stated.everywhere = std::ranges::none_of(
      program->targets, [&](const ProgramTarget& target) { return target.*frame < 0; });
  return stated;
}

std::vector<std::string> assumptions(const Robot& controller, const RobotProgram* program,
                                     const Arguments& arguments) {
  return {
      fmt::format(
          "The controller runs {} and nothing else. If a calibrated model is active in it (KUKA "
          "absolute accuracy, ABB AbsAcc, UR calibration.conf), that is --controller; otherwise "
          "the program is corrected twice.",
          arguments.controller),
      app::assumed_frames(controller, arguments, stated_frames(program, &ProgramTarget::tool),
                          stated_frames(program, &ProgramTarget::base))};
}

// With points between the targets of a program `text` if --spacing-mm is given.
DividedProgram compensate_file(const Robot& robot, const Robot& controller, const ProgramFile& file,
                               const RobotProgram* text, const Arguments& arguments) {
  const CompensationOptions options = compensation_options(arguments, controller);
  if (text && arguments.spacing_mm)
    return divide_moves(robot, controller, *text, file.program, options,
                        *arguments.spacing_mm * kMillimetre);
  DividedProgram found;
  found.targets = compensate(robot, controller, file.program, options);
  return found;
}

CommandKind command_kind(const Arguments& arguments, const Program& program) {
  if (arguments.commands.empty())
    return program.is_cartesian() ? CommandKind::cartesian : CommandKind::joints;
  return arguments.commands == "joints" ? CommandKind::joints : CommandKind::cartesian;
}

void refuse_options_of_tables(const app::Command& command, const Arguments& arguments) {
  if (!arguments.commands.empty())
    throw app::UsageError("--commands: the targets of a program stay of their kind; leave it out");
  if (command.output != "-")
    throw app::UsageError("-o: a program goes to --program-out, and there is no other product");
}

// What the parser warned of may be why a target is not reached.
template <class Work>
auto with_warnings(app::Command& command, const RobotProgram* program, Work work) {
  try {
    return work();
  } catch (const InputError&) {
    if (program)
      for (const std::string& warning : program->warnings) command.warn(warning);
    throw;
  }
}

void warn_of_station(app::Command& command, const std::vector<std::string>& not_applied) {
  for (const std::string& effect : not_applied)
    command.warn("not applied, because it belongs to the station, or may: " + effect);
}

void warn_of_targets(app::Command& command, const Arguments& arguments, const Robot& controller,
                     const RobotProgram* program, const ProgramFile& file) {
  app::warn_of_tool(command, arguments);
  if (!program) {
    if (const std::string doubt = doubt_of_table(file.source, file.program); !doubt.empty())
      command.warn(doubt);
    return;
  }
  for (const std::string& doubt : doubts_of_program(
           *program, compensation_options(arguments, controller), !arguments.tool.empty()))
    command.warn(doubt);
}

void warn_of_hints(app::Command& command, const Arguments& arguments, const Robot& controller,
                   const ProgramFile& file) {
  const std::string doubt = contradiction_of_hints(file.program, controller,
                                                   compensation_options(arguments, controller));
  if (!doubt.empty()) command.warn(file.source + ": " + doubt);
}

// Commands for all targets of a file, or of a program with the joints `joints`.
DividedProgram correct(app::Command& command, const app::Models& models, RobotProgram* program,
                       const ProgramJoints& joints, ProgramFile& file, const Arguments& arguments) {
  const Robot &robot = models.robot, &controller = models.controller;
  const CompensationOptions options = compensation_options(arguments, controller);
  const auto read = [&] {
    if (program)
      file.program = with_warnings(command, program,
                                   [&] { return program_targets(*program, options, joints); });
    app::fill_conditions(file.program.visits, arguments, {&robot, &controller});
  };
  read();
  warn_of_targets(command, arguments, controller, program, file);
  if (file.program.is_cartesian() ||
      (!program && command_kind(arguments, file.program) == CommandKind::cartesian))
    app::require_flange(controller, arguments);
  for (const Robot* of : {&robot, &controller})
    app::require_conditions(file.program.visits, *of, arguments,
                            program ? app::HasColumns::no : app::HasColumns::yes);
  std::optional<DividedProgram> divided;
  while (!divided) try {
      divided = compensate_file(robot, controller, file, program, arguments);
    } catch (const UnreachableTarget& error) {
      if (program && leave_what_is_out_of_reach(error, *program)) {
        read();
        continue;
      }
      if (program)
        for (const std::string& warning : program->warnings) command.warn(warning);
      warn_of_hints(command, arguments, controller, file);
      const size_t row = error.row;
      throw InputError(fmt::format("{}:{}: target '{}': {}", file.source,
                                   file.program.visits.line[row], file.program.visits.pose_ids[row],
                                   error.what()));
    }
  const auto nearest = std::ranges::min_element(
      divided->targets, {}, [](const CorrectedTarget& target) { return target.before.position; });
  app::refuse_other_arm(nearest->before.position, app::pair_of(robot, controller, arguments));
  warn_of_hints(command, arguments, controller, file);
  // Commands of compensate() show in their numbers, whatever became of the marks in the file.
  if (const auto found = program ? find_round_where_reached(*program, divided->targets, joints)
                                 : find_round_where_reached(controller, divided->targets))
    throw InputError(
        why_corrected_before(*found, file.program.visits, file.source, arguments.robot));
  return std::move(*divided);
}

// What is said of several programs is said once.
void add_new(const std::vector<std::string>& sentences, std::vector<std::string>& all) {
  for (const std::string& sentence : sentences)
    if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
}

bool is_noted(const std::vector<CorrectedTarget>& targets) {
  return std::ranges::any_of(targets, [](const auto& target) { return !target.notes.empty(); });
}

// The programs of a folder, each by itself; their texts are written together.
int run_project(app::Command& command, const app::Models& models, Arguments& arguments) {
  const Robot &robot = models.robot, &controller = models.controller;
  if (arguments.spacing_mm || !arguments.summary.empty() || arguments.page.is_wanted())
    throw app::UsageError(
        "--spacing-mm, --summary, --report and --plots are for one program; leave them out with "
        "--project");
  if (!arguments.commands.empty())
    throw app::UsageError("--commands: the targets of a program stay of their kind; leave it out");
  arguments.project.has_base = !arguments.base.empty();
  arguments.project.has_tool = !arguments.tool.empty();
  bool is_reached = true;
  std::vector<std::string> in_doubt;
  const bool is_whole = app::correct_project(
      command, arguments.project, arguments.program, [&](RobotProgram& program) {
        refuse_two_tools(program, arguments.tool_is_measured);
        ProgramFile file;
        file.source = program.texts[0].name;
        const ProgramJoints joints = joints_of_program(program, controller, arguments.controller);
        std::vector<CorrectedTarget> targets =
            correct(command, models, &program, joints, file, arguments).targets;
        add_new(doubts(robot, controller, targets, file.program.visits, arguments), in_doubt);
        app::ProjectCommands found{program_commands(program, targets, joints), {}};
        found.moves = corrected_moves(program, targets);
        for (const std::string& note :
             sentences_of_notes(targets, file.program.visits, file.source))
          command.warn(note);
        is_reached &= !is_noted(targets) && found.commands.warnings.empty();
        return found;
      });
  PredictionConditions conditions;
  app::warn_of_doubts(command, in_doubt, conditions);
  warn_of_station(command, station_effects(robot, arguments.tool_is_measured));
  const bool is_strict = is_whole && is_reached && in_doubt.empty();
  return (arguments.strict && !is_strict) || (arguments.require_all && !is_whole)
             ? app::kNotReached
             : app::kSuccess;
}

int run(app::Command& command, Arguments& arguments) {
  const app::Models models = app::read_models(command, arguments);
  const Robot &robot = models.robot, &controller = models.controller;
  const std::optional<About> about = app::read_about(command, arguments.page);
  app::refuse_other_files(robot, controller, arguments);
  if (!arguments.project.folder.empty()) return run_project(command, models, arguments);
  if (!arguments.program.frames.empty() && arguments.program.path.empty())
    throw app::UsageError("--frame: is for --program or --project");
  std::optional<RobotProgram> read;
  ProgramJoints joints;
  ProgramFile file;
  if (!arguments.program.path.empty()) {
    refuse_options_of_tables(command, arguments);
    read = app::read_robot_program(command, arguments.program);
    refuse_two_tools(*read, arguments.tool_is_measured);
    file.source = read->texts[0].name;
    joints = joints_of_program(*read, controller, arguments.controller);
  } else {
    file = command.read_program(command.input, controller);
  }
  RobotProgram* const program = read ? &*read : nullptr;
  DividedProgram divided = correct(command, models, program, joints, file, arguments);
  std::vector<CorrectedTarget>& targets = divided.targets;

  PredictionConditions conditions{robot.name, controller.name,
                                  assumptions(controller, program, arguments),
                                  station_effects(robot, arguments.tool_is_measured)};
  std::optional<BetweenPoints> between;
  if (arguments.spacing_mm) between = divided.between;
  const std::vector<std::string> in_doubt =
      doubts(robot, controller, targets, file.program.visits, arguments);
  app::warn_of_doubts(command, in_doubt, conditions);
  warn_of_station(command, conditions.not_applied);
  bool is_followed = true;
  if (program)
    is_followed =
        app::write_robot_program(command, *program, program_commands(*program, targets, joints),
                                 divided.inserted, arguments.program);
  else
    write_output(command.output,
                 write_commands(file, targets, command_kind(arguments, file.program)));
  bool is_whole = std::ranges::all_of(targets, &CorrectedTarget::is_corrected);
  if (program) {
    const CorrectedMoves moves = corrected_moves(*program, targets);
    is_whole = conditions.all_moves = moves.corrected == moves.all;
    conditions.moves = moves.sentence;
  }
  for (const std::string& note : sentences_of_notes(targets, file.program.visits, file.source))
    command.warn(note);
  for (const std::string& left :
       sentences_of_moves(divided.between, file.program.visits, file.source)) {
    command.warn(left);
    is_followed = false;
  }
  if (!arguments.summary.empty())
    write_output(arguments.summary, write_compensation(targets, file.program, between, conditions,
                                                       command.provenance()));
  command.report((program ? file.source + ": " + conditions.moves + "\n" : "") +
                 compensation_table(targets, file.program));
  if (arguments.page.is_wanted())
    app::write_report(command, arguments.page,
                      compensation_page(targets, file.program, between, conditions,
                                        app::page_head(command, about)));
  const bool is_strict = !is_noted(targets) && is_followed && in_doubt.empty();
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
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
