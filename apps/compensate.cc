#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_targets.h"
#include "armtrue/io/compensation_io.h"
#include "armtrue/io/output.h"
#include "armtrue/kinematics/units.h"
#include "columns.h"
#include "command_line.h"
#include "robot_program_files.h"

using namespace armtrue;

namespace {

constexpr double kOtherArm = 50 * kMillimetre;  // no two models of one arm are as far apart
constexpr double kNothing = 1e-9;               // [m]
constexpr size_t kMostNames = 5;                // in one warning

struct Arguments {
  std::string robot, controller, commands, session, summary, uncovered = "keep";
  std::vector<double> base, tool, start;
  bool tool_is_measured = false, strict = false;
  double max_mm = CompensationOptions{}.max_correction / kMillimetre;
  std::optional<double> payload_kg, time_s, temperature_c;
  app::RobotProgramFiles program;
};

void add_frames(app::Command& command, Arguments& arguments) {
  app::Option tool = command.numbers("--tool", arguments.tool, 6, app::kPoseForm,
                                     "The program's tool: the TCP in R_7 (KUKA $TOOL), as "
                                     "x,y,z,a,b,c in mm and deg; R_7 itself if absent");
  command
      .flag("--tool-is-measured", arguments.tool_is_measured,
            "The TCP is the frame that was measured: tool and its effects are those of --robot")
      .excludes(tool);
  command.numbers("--base", arguments.base, 6, app::kPoseForm,
                  "The program's frame in R_0 (KUKA $BASE), as x,y,z,a,b,c in mm and deg; R_0 "
                  "itself if absent");
}

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input("Targets of a program, in its order");
  command.add_output();
  command.option("--robot", arguments.robot, "The identified arm, as close-loop writes it")
      .required();
  command.option("--controller", arguments.controller, "The model that the controller runs")
      .required();
  add_frames(command, arguments);
  command
      .option("--commands", arguments.commands,
              "What is commanded: joints, or cartesian, the pose that the controller's model has "
              "at these joints; as the targets if absent")
      .check(app::one_of({"joints", "cartesian"}));
  command.numbers("--start", arguments.start, 6, "q1,...,q6 in deg",
                  "Joint angles near the first Cartesian target, if it has none");
  command.option("--session", arguments.session,
                 "The session of --robot whose zero offsets hold, if they differ");
  command.option("--payload-kg", arguments.payload_kg, "Payload at the TCP, if there is no column")
      .check(app::not_below_zero());
  command.option("--t-s", arguments.time_s,
                 "Time since the start of the campaign, if there is no column");
  command.option("--temp-c", arguments.temperature_c,
                 "Temperature of all sensors, if there are no columns");
  command
      .option("--max-mm", arguments.max_mm,
              "Targets that need a larger correction are left as programmed")
      .check(app::above_zero())
      .default_shown();
  command
      .option("--uncovered", arguments.uncovered,
              "Targets that the readings say little about: keep their corrections, or leave them "
              "as programmed")
      .check(app::one_of({"keep", "leave"}))
      .default_shown();
  app::add_robot_program(command, arguments.program);
  command.add_output("--summary", arguments.summary, "Write counts, errors and the worst here");
  command.flag("--strict", arguments.strict,
               "Exit with 3 if a target has a note, or the assumptions are in doubt");
  command.add_columns(app::kProgramColumns);
}

CompensationOptions compensation_options(const Arguments& arguments) {
  CompensationOptions options;
  options.base = app::pose_from_numbers(arguments.base);
  options.tool = app::pose_from_numbers(arguments.tool);
  options.tool_is_measured = arguments.tool_is_measured;
  options.max_correction = arguments.max_mm * kMillimetre;
  options.correct_uncovered = arguments.uncovered == "keep";
  if (!arguments.start.empty())
    options.start = kDegree * Eigen::Map<const JointVector>(arguments.start.data());
  return options;
}

// One value of the command line for a column that all rows lack.
template <typename Column, typename Value>
void fill(Column& column, const Value& value, const ProgramFile& file, const std::string& option,
          const std::string& name) {
  if (!column.empty())
    throw InputError(file.source + ": has the column '" + name + "' and " + option +
                     " is given too; keep one of them");
  column.assign(static_cast<size_t>(file.program.rows()), value);
}

void fill_context(ProgramFile& file, const Arguments& arguments,
                  const std::vector<const Robot*>& robots) {
  Campaign& visits = file.program.visits;
  if (arguments.payload_kg)
    fill(visits.payload_kg, *arguments.payload_kg, file, "--payload-kg", "payload_kg");
  if (arguments.time_s) fill(visits.time_s, *arguments.time_s, file, "--t-s", "t_s");
  if (!arguments.temperature_c) return;
  std::array<double, kMaxTemperatures> all{};
  all.fill(*arguments.temperature_c);
  fill(visits.temperature_c, all, file, "--temp-c", "temp_NAME_c");
  std::set<std::string> names;
  for (const Robot* robot : robots)
    for (const Effect& effect : robot->effects)
      if (effect.driver.involves(DriverKind::temperature)) names.insert(effect.driver.where);
  visits.temperature_names.assign(names.begin(), names.end());
  visits.temperature_names.resize(std::min<size_t>(names.size(), kMaxTemperatures));
}

void refuse_other_files(const Robot& robot, const Robot& controller, const Arguments& arguments) {
  if (states_calibration(controller) && !states_calibration(robot))
    throw InputError(arguments.controller +
                     ": states standard deviations, an uncertainty or effects, as a calibrated "
                     "robot does, and " +
                     arguments.robot +
                     " does not; exchange --robot and --controller, or every error would be "
                     "doubled");
}

void refuse_other_arm(const std::vector<CorrectedTarget>& targets, const Arguments& arguments) {
  const auto near = std::ranges::min_element(
      targets, {}, [](const CorrectedTarget& target) { return target.before.position; });
  if (near->before.position < kOtherArm) return;
  throw InputError(
      fmt::format("{} and {} are different arms: their flanges stand {:.4g} mm apart "
                  "or more at every target; give two models of one arm, with the same "
                  "R_0, R_7 and zeros of the joints",
                  arguments.robot, arguments.controller, near->before.position / kMillimetre));
}

std::vector<std::string> station_effects(const Robot& robot, bool tool_is_measured) {
  std::vector<std::string> names;
  for (const Effect& effect : robot.effects)
    if (!moves_program(effect, tool_is_measured))
      names.push_back(fmt::format("{} ({} follows {})", effect.name, effect.parameter,
                                  to_string(effect.driver)));
  return names;
}

// Loads that the rows state, and no effect of the arm follows.
void find_idle_loads(const Robot& robot, const Campaign& visits, std::vector<std::string>& found) {
  bool follows_payload = false, follows_force = false;
  for (const Effect& effect : robot.effects) {
    const Driver& driver = effect.driver;
    const bool follows_weight =
        driver.involves(DriverKind::gravity_torque) || driver.involves(DriverKind::moment);
    follows_payload |= driver.involves(DriverKind::payload) ||
                       (follows_weight && !robot.bodies.empty());  // no part of the basis
    follows_force |= driver.involves(DriverKind::force);
  }
  const bool has_payload = std::ranges::any_of(visits.payload_kg, [](double kg) { return kg > 0; });
  const bool has_force =
      std::ranges::any_of(visits.force_n, [](const auto& force) { return !force.isZero(0); });
  if (has_payload && !follows_payload)
    found.push_back("the payload changes nothing: no effect of the robot file follows it");
  if (has_force && !follows_force)
    found.push_back("the force changes nothing: no effect of the robot file follows it");
}

// What puts the assumptions in doubt, in sentences.
std::vector<std::string> doubts(const Robot& robot, const Robot& controller,
                                const std::vector<CorrectedTarget>& targets, const Campaign& visits,
                                const Arguments& arguments) {
  std::vector<std::string> found;
  if (states_calibration(controller))
    found.push_back(arguments.controller +
                    " is itself calibrated: the commands hold only if the controller runs it; if "
                    "it runs a nominal model, give that as --controller");
  if (!robot.uncertainty)
    found.push_back(arguments.robot +
                    " does not state its uncertainty: nobody knows which targets its readings "
                    "cover; calibrate and close-loop --robot-out write it");
  else if (robot.uncertainty->reading.orientation == 0)
    found.push_back(arguments.robot +
                    " comes from points or distances: no orientation was measured, so corrections "
                    "of orientation follow from the joints alone");
  if (const std::vector<std::string> names = parameters_of_station(robot); !names.empty())
    found.push_back(fmt::format(
        "{}: {} were identified without base or tool, so they may hold where the instrument and "
        "the reflector stood, and move the program by it; calibrate with identify: auto",
        arguments.robot, fmt::join(names, ", ")));
  find_idle_loads(robot, visits, found);
  const bool is_nothing = std::ranges::all_of(
      targets, [](const CorrectedTarget& t) { return t.before.position < kNothing; });
  if (is_nothing)
    found.push_back("the controller already runs the model of " + arguments.robot +
                    ": there is nothing to correct");
  return found;
}

std::vector<std::string> assumptions(const Arguments& arguments) {
  std::vector<std::string> list;
  list.push_back(fmt::format(
      "The controller runs {} and nothing else. If a calibrated model is active in it (KUKA "
      "absolute accuracy, ABB AbsAcc, UR calibration.conf), that is --controller; otherwise the "
      "program is corrected twice.",
      arguments.controller));
  const auto place = [](const std::vector<double>& numbers, const std::string& none) {
    return numbers.empty() ? none : fmt::format("{:g}", fmt::join(numbers, ", "));
  };
  list.push_back("The tool is " +
                 (arguments.tool_is_measured ? "that of " + arguments.robot
                                             : place(arguments.tool, "R_7, the flange")) +
                 "; the program's frame is " + place(arguments.base, "R_0, the robot foot") + ".");
  return list;
}

void warn_of_notes(const app::Command& command, const std::vector<CorrectedTarget>& targets,
                   const ProgramFile& file) {
  for (CommandNote note : command_notes()) {
    std::string names;
    size_t count = 0;
    for (size_t row = 0; row < targets.size(); ++row) {
      if (!targets[row].has(note)) continue;
      if (count++ < kMostNames)
        names += (names.empty() ? "" : ", ") + file.program.visits.pose_ids[row];
    }
    if (count == 0) continue;
    command.warn(fmt::format("{}: {} of {} targets: {} ({}{})", file.source, count, targets.size(),
                             to_string(note), names, count > kMostNames ? ", ..." : ""));
  }
}

std::vector<CorrectedTarget> compensate_file(const Robot& robot, const Robot& controller,
                                             const ProgramFile& file,
                                             const CompensationOptions& options) {
  try {
    return compensate(robot, controller, file.program, options);
  } catch (const UnreachableTarget& error) {
    const auto row = static_cast<size_t>(error.row);
    throw InputError(fmt::format("{}:{}: target '{}': {}", file.source,
                                 file.program.visits.line[row], file.program.visits.pose_ids[row],
                                 error.what()));
  }
}

Robot robot_of_session(const Robot& robot, const Arguments& arguments) {
  try {
    return in_session(robot, arguments.session);
  } catch (const std::invalid_argument& error) {
    throw InputError(arguments.robot + ": " + error.what());
  }
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

void refuse_two_tools(const RobotProgram& program, const Arguments& arguments) {
  for (const ProgramTarget& target : program.targets)
    if (arguments.tool_is_measured && target.tool >= 0)
      throw InputError(fmt::format(
          "{}:{}: the program names the tool '{}', and --tool-is-measured is given; leave it out",
          program.texts[0].name, target.line,
          program.frames[static_cast<size_t>(target.tool)].name));
}

int run(app::Command& command, const Arguments& arguments) {
  const Robot robot = robot_of_session(command.read_robot(arguments.robot).robot, arguments);
  const Robot controller = command.read_robot(arguments.controller).robot;
  refuse_other_files(robot, controller, arguments);
  std::optional<RobotProgram> program;
  ProgramFile file;
  if (!arguments.program.path.empty()) {
    refuse_options_of_tables(command, arguments);
    program = app::read_robot_program(command, arguments.program);
    refuse_two_tools(*program, arguments);
    file.source = program->texts[0].name;
    file.program = program_targets(*program, compensation_options(arguments));
  } else {
    file = command.read_program(command.input);
  }
  fill_context(file, arguments, {&robot, &controller});
  std::vector<CorrectedTarget> targets =
      compensate_file(robot, controller, file, compensation_options(arguments));
  refuse_other_arm(targets, arguments);

  CompensationStory story{robot.name, controller.name, assumptions(arguments),
                          station_effects(robot, arguments.tool_is_measured)};
  const std::vector<std::string> in_doubt =
      doubts(robot, controller, targets, file.program.visits, arguments);
  for (const std::string& doubt : in_doubt) {
    command.warn(doubt);
    story.assumed.push_back(doubt + ".");
  }
  for (const std::string& effect : story.not_applied)
    command.warn("not applied, because it belongs to the station: " + effect);
  bool is_followed = true;
  if (program)
    is_followed = app::write_robot_program(command, *program, targets, arguments.program);
  else
    write_output(command.output,
                 write_commands(file, targets, command_kind(arguments, file.program)));
  warn_of_notes(command, targets, file);
  if (!arguments.summary.empty())
    write_output(arguments.summary,
                 write_compensation(targets, file.program, story, command.provenance()));
  command.report(compensation_table(targets, file.program));
  const bool is_noted = std::ranges::any_of(
      targets, [](const CorrectedTarget& target) { return !target.notes.empty(); });
  return arguments.strict && (is_noted || !is_followed || !in_doubt.empty()) ? app::kNotReached
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
