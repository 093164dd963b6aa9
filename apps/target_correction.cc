#include "target_correction.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/compensation/corrected_before.h"
#include "armtrue/compensation/program_findings.h"
#include "armtrue/compensation/target_doubts.h"
#include "armtrue/io/products/compensation_io.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"

namespace armtrue::app {
namespace {

// With points between the targets of a program `text` if --spacing-mm is given.
DividedProgram compensate_file(const Robot& robot, const Robot& controller, const ProgramFile& file,
                               const RobotProgram* text, const CorrectionArguments& arguments) {
  const CompensationOptions options = compensation_options(arguments, controller);
  if (text && arguments.spacing_mm)
    return divide_moves(robot, controller, *text, file.program, options,
                        *arguments.spacing_mm * kMillimetre);
  DividedProgram found;
  found.targets = compensate(robot, controller, file.program, options);
  return found;
}

// What the parser warned of may be why a target is not reached.
template <class Work>
auto with_warnings(Command& command, const RobotProgram* program, Work work) {
  try {
    return work();
  } catch (const InputError&) {
    if (program) warn_of_all(command, program->warnings);
    throw;
  }
}

void warn_of_targets(Command& command, const CorrectionArguments& arguments,
                     const Robot& controller, const RobotProgram* program,
                     const ProgramFile& file) {
  warn_of_units(command, controller, arguments);
  if (!program) return warn_of_all(command, {doubt_of_table(file.source, file.program)});
  warn_of_all(command, doubts_of_program(*program, compensation_options(arguments, controller),
                                         !arguments.tool.empty()));
}

void warn_of_hints(Command& command, const CorrectionArguments& arguments, const Robot& controller,
                   const ProgramFile& file) {
  const std::string doubt =
      contradiction_of_hints(file.program, controller, compensation_options(arguments, controller));
  if (!doubt.empty()) command.warn(file.source + ": " + doubt);
}

void warn_of_calls(Command& command, const std::string& source, const std::string& callers) {
  command.warn(fmt::format(
      "{}: begins in the posture of its calls ({}); whoever else starts it may come in another",
      source, callers));
}

// What is said of several programs is said once.
void add_new(const std::vector<std::string>& sentences, std::vector<std::string>& all) {
  for (const std::string& sentence : sentences)
    if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
}

}  // namespace

DividedProgram correct(Command& command, const Models& models, RobotProgram* program,
                       const ProgramJoints& joints, ProgramFile& file,
                       CorrectionArguments arguments,
                       const std::function<PosturesAtCalls()>& postures_at_calls) {
  const Robot &robot = models.robot, &controller = models.controller;
  // --start is of programs that no other one calls.
  auto start = postures_at_calls ? std::exchange(arguments.start, {}) : decltype(arguments.start){};
  const CompensationOptions options = compensation_options(arguments, controller);
  if (program) remove_what_never_runs(*program);
  const auto read = [&] {
    if (program)
      file.program = with_warnings(command, program,
                                   [&] { return program_targets(*program, options, joints); });
    fill_conditions(file.program.visits, arguments, {&robot, &controller});
  };
  if (program)
    warn_of_all(command, {doubt_of_stated_arm(*program, controller, joints, arguments.controller),
                          doubt_of_arm_name(*program, controller, arguments.controller)});
  if (program) leave_what_has_no_place(*program, joints);
  read();
  warn_of_targets(command, arguments, controller, program, file);
  if (file.program.is_cartesian() ||
      (!program && command_kind(arguments, file.program) == CommandKind::cartesian))
    require_flange(controller, arguments);
  for (const Robot* of : {&robot, &controller})
    require_conditions(file.program.visits, *of, arguments,
                       program ? HasColumns::no : HasColumns::yes);
  std::optional<DividedProgram> divided;
  while (!divided) try {
      divided = compensate_file(robot, controller, file, program, arguments);
    } catch (const UnreachableTarget& error) {
      if (error.lacks_start && postures_at_calls) {
        const PosturesAtCalls at_calls = postures_at_calls();
        arguments.posture_of_calls = common_posture(controller, options, joints, at_calls.angles);
        if (arguments.posture_of_calls) {
          warn_of_calls(command, file.source, at_calls.callers);
          continue;
        }
        if (at_calls.angles.empty() && !start.empty()) {
          arguments.start = std::exchange(start, {});
          continue;
        }
        if (!start.empty())
          throw InputError(fmt::format(
              "{}:{}: target '{}': its calls ({}) come in several postures, and --start is no "
              "other "
              "than one of them; state its branch (KUKA S and T, ABB ConfL \\On), or bring the arm "
              "to one posture before the calls",
              file.source, file.program.visits.line[error.row],
              file.program.visits.pose_ids[error.row], at_calls.callers));
      }
      if (program && leave_what_is_out_of_reach(error, *program)) {
        read();
        continue;
      }
      if (program) warn_of_all(command, program->warnings);
      warn_of_hints(command, arguments, controller, file);
      const size_t row = error.row;
      throw InputError(fmt::format("{}:{}: target '{}': {}", file.source,
                                   file.program.visits.line[row], file.program.visits.pose_ids[row],
                                   error.what()));
    }
  const auto nearest = std::ranges::min_element(
      divided->targets, {}, [](const CorrectedTarget& target) { return target.before.position; });
  refuse_other_arm(nearest->before.position, pair_of(robot, controller, arguments));
  warn_of_hints(command, arguments, controller, file);
  // Commands of compensate() show in their numbers, whatever became of the marks in the file.
  if (const auto found = program ? find_round_where_reached(*program, divided->targets, joints)
                                 : find_round_where_reached(controller, divided->targets))
    throw InputError(
        why_corrected_before(*found, file.program.visits, file.source, arguments.robot));
  return std::move(*divided);
}

std::vector<std::string> doubts_of_commands(const Models& models,
                                            const std::vector<CorrectedTarget>& targets,
                                            const Campaign& visits,
                                            const CorrectionArguments& arguments) {
  std::vector<std::string> found =
      doubts_of_models(pair_of(models.robot, models.controller, arguments), visits, "the commands");
  if (need_no_correction(targets))
    found.push_back("the controller already runs the model of " + arguments.robot +
                    ": there is nothing to correct");
  return found;
}

bool is_noted(const std::vector<CorrectedTarget>& targets) {
  return std::ranges::any_of(targets, [](const auto& target) { return !target.notes.empty(); });
}

int correct_folder(Command& command, const Models& models, CorrectionArguments& arguments) {
  if (arguments.spacing_mm || !arguments.summary.empty() || arguments.page.is_wanted())
    throw UsageError(
        "--spacing-mm, --summary, --report and --plots are for one program; leave them out with "
        "--project");
  if (!arguments.commands.empty())
    throw UsageError("--commands: the targets of a program stay of their kind; leave it out");
  arguments.project.has_base = !arguments.base.empty();
  arguments.project.has_tool = !arguments.tool.empty();
  bool is_reached = true;
  std::vector<std::string> in_doubt;
  const bool is_whole = correct_project(
      command, arguments.project, arguments.program,
      [&](RobotProgram& program, const std::function<PosturesAtCalls()>& postures_at_calls) {
        refuse_two_tools(program, arguments.tool_is_measured);
        ProgramFile file;
        file.source = program.texts[0].name;
        const ProgramJoints joints =
            joints_of_program(program, models.controller, arguments.controller);
        std::vector<CorrectedTarget> targets =
            correct(command, models, &program, joints, file, arguments, postures_at_calls).targets;
        add_new(doubts_of_commands(models, targets, file.program.visits, arguments), in_doubt);
        ProjectCommands found{
            program_commands(program, file.program, targets, joints, models.controller,
                             compensation_options(arguments, models.controller)),
            {}};
        found.moves = corrected_moves(program, targets);
        warn_of_all(command, sentences_of_notes(targets, file.program.visits, file.source));
        is_reached &= !is_noted(targets) && found.commands.warnings.empty();
        return found;
      });
  PredictionConditions conditions;
  warn_of_doubts(command, in_doubt, conditions);
  warn_of_station(command, station_effects(models.robot, arguments.tool_is_measured));
  const bool is_strict = is_whole && is_reached && in_doubt.empty();
  return (arguments.strict && !is_strict) || (arguments.require_all && !is_whole) ? kNotReached
                                                                                  : kSuccess;
}

}  // namespace armtrue::app
