#include "program_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "armtrue/compensation/target_doubts.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "option_text.h"

namespace armtrue::app {
namespace {

// One value of the command line for a column that all rows lack.
template <typename Column, typename Value>
void fill(Column& column, const Value& value, const Campaign& visits, const std::string& option,
          const std::string& name) {
  if (!column.empty())
    throw InputError(visits.source + ": has the column '" + name + "' and " + option +
                     " is given too; keep one of them");
  column.assign(visits.rows(), value);
}

}  // namespace

Pose pose_from_numbers(const std::vector<double>& n) {
  if (n.empty()) return {};
  return {rotation_from_abc(n[3] * kDegree, n[4] * kDegree, n[5] * kDegree),
          Eigen::Vector3d(n[0], n[1], n[2]) * kMillimetre};
}

void add_models(Command& command, ProgramArguments& arguments) {
  command.file("--robot", arguments.robot, "The identified arm, as close-loop writes it")
      .required();
  command
      .file("--controller", arguments.controller,
            "The model that the controller runs; nominal: the file that --robot was made from")
      .required();
}

void add_frames(Command& command, ProgramArguments& arguments) {
  Option tool = command.numbers("--tool", arguments.tool, 6, kPoseForm,
                                "The program's tool: the TCP in the frame of the last link, R_7 "
                                "of six axes (KUKA $TOOL), as x,y,z,a,b,c in mm and deg; that "
                                "frame itself if absent");
  command
      .flag("--tool-is-measured", arguments.tool_is_measured,
            "The TCP is the frame that was measured: use tool and its effects from --robot")
      .excludes(tool);
  command
      .option("--flange", arguments.flange,
              "Where the program's flange is, if tool of --controller is turned by right angles: "
              "last-link (R_7; tool is where the reflector stood) or tool (the robot is a URDF "
              "that an earlier version converted)")
      .check(one_of({"last-link", "tool"}));
  command.numbers("--base", arguments.base, 6, kPoseForm,
                  "The program's frame in R_0 (KUKA $BASE), as x,y,z,a,b,c in mm and deg; R_0 "
                  "itself if absent");
}

void warn_of_units(Command& command, const Robot& controller, const ProgramArguments& arguments) {
  warn_of_all(command, {doubt_of_tool("of --tool", pose_from_numbers(arguments.tool)),
                        doubt_of_frame("of --base", pose_from_numbers(arguments.base))});
  if (!arguments.start.empty()) joints_of(command, arguments.start, controller, "--start");
}

void add_conditions(Command& command, ProgramArguments& arguments) {
  command.option("--session", arguments.session,
                 "Session of --robot whose zero offsets apply, if they differ");
  command.option("--payload-kg", arguments.payload_kg, "Payload at the TCP, if there is no column")
      .check(payload_of_arm());
  command.option("--t-s", arguments.time_s,
                 "Time since the start of the campaign, if there is no column");
  command
      .option("--temp-c", arguments.temperature_c,
              "Temperature of all sensors, if there are no columns")
      .check(temperature_of_arm());
}

CompensationOptions program_options(const ProgramArguments& arguments, const Robot& controller) {
  CompensationOptions options;
  if (arguments.flange == "tool") options.flange = controller.chain.tool;
  options.base = pose_from_numbers(arguments.base);
  options.tool = options.flange * pose_from_numbers(arguments.tool);
  options.tool_is_measured = arguments.tool_is_measured;
  if (!arguments.start.empty()) options.start = joints_of(arguments.start, controller, "--start");
  return options;
}

void fill_conditions(Campaign& visits, const ProgramArguments& arguments,
                     const std::vector<const Robot*>& robots) {
  if (arguments.payload_kg)
    fill(visits.payload_kg, *arguments.payload_kg, visits, "--payload-kg", "payload_kg");
  if (arguments.time_s) fill(visits.time_s, *arguments.time_s, visits, "--t-s", "t_s");
  if (!arguments.temperature_c) return;
  std::array<double, kMaxTemperatures> all{};
  all.fill(*arguments.temperature_c);
  fill(visits.temperature_c, all, visits, "--temp-c", "temp_NAME_c");
  std::set<std::string> names;
  for (const Robot* robot : robots)
    for (const Effect& effect : robot->effects)
      if (effect.driver.involves(DriverKind::temperature)) names.insert(effect.driver.where);
  visits.temperature_names.assign(names.begin(), names.end());
  visits.temperature_names.resize(std::min<size_t>(names.size(), kMaxTemperatures));
}

namespace {

void require_conditions_of(const Effect& effect, const Campaign& visits, HasColumns has_columns) {
  for (const Effect& member : effect.members) require_conditions_of(member, visits, has_columns);
  for (const auto& [kind, option] :
       {std::pair(DriverKind::time, "--t-s"), std::pair(DriverKind::temperature, "--temp-c")}) {
    if (!effect.driver.involves(kind)) continue;
    const std::string column = missing_column(visits, kind, effect.driver.where);
    if (column.empty()) continue;
    throw InputError(fmt::format(
        "{}: the effect '{}' makes {} follow {}; give {}{}, or take the effect out of its file",
        visits.source, effect.name, to_string(effect.parameter), to_string(effect.driver), option,
        has_columns == HasColumns::yes ? ", add the column " + column : ""));
  }
}

}  // namespace

void require_conditions(const Campaign& visits, const Robot& robot,
                        const ProgramArguments& arguments, HasColumns has_columns) {
  for (const Effect& effect : robot.effects)
    if (moves_program(effect, arguments.tool_is_measured))
      require_conditions_of(effect, visits, has_columns);
}

Robot robot_of_session(const Robot& robot, const ProgramArguments& arguments) {
  try {
    return in_session(robot, arguments.session);
  } catch (const std::invalid_argument& error) {
    throw InputError(arguments.robot + ": " + error.what());
  }
}

namespace {

// The file that a calibrated robot was made from. Its path is one from the folder in which it was
// made; here, the file may stand beside it.
RobotFile nominal_of(const RobotFile& calibrated, const std::string& robot) {
  const auto& [stated, sha256] = *calibrated.nominal;
  const std::filesystem::path given(stated), folder = std::filesystem::path(robot).parent_path();
  std::string changed;
  for (const std::filesystem::path& path : {given, folder / given, folder / given.filename()}) {
    if (std::error_code error; !std::filesystem::exists(path, error)) continue;
    RobotFile nominal = armtrue::read_robot(path.string());
    if (nominal.sha256 == sha256) return nominal;
    changed = path.string();
  }
  if (!changed.empty())
    throw InputError(changed + ": has changed since " + robot +
                     " was made from it; name the model that the controller runs as --controller");
  throw InputError(fmt::format(
      "--controller nominal: {} says that it was made from {}, which is not there, nor beside it; "
      "name that file as --controller",
      robot, stated));
}

}  // namespace

Models read_models(Command& command, ProgramArguments& arguments) {
  const RobotFile file = command.read_robot(arguments.robot);
  if (arguments.controller != "nominal")
    return {robot_of_session(file.robot, arguments),
            command.read_robot(arguments.controller).robot};
  if (!file.nominal)
    throw InputError(arguments.robot +
                     ": does not say which nominal robot it was made from; name the file as "
                     "--controller");
  const RobotFile nominal = nominal_of(file, arguments.robot);
  command.add_robot_to_inputs(nominal);
  arguments.controller = nominal.name;
  return {robot_of_session(file.robot, arguments), nominal.robot};
}

namespace {

void refuse_if(const std::string& why) {
  if (!why.empty()) throw InputError(why);
}

}  // namespace

ModelPair pair_of(const Robot& robot, const Robot& controller, const ProgramArguments& arguments) {
  return {robot, controller, arguments.robot, arguments.controller};
}

void refuse_other_files(const Robot& robot, const Robot& controller,
                        const ProgramArguments& arguments) {
  require_same_joints(robot, arguments.robot, controller, arguments.controller);
  refuse_if(why_not_a_pair(pair_of(robot, controller, arguments)));
}

void require_flange(const Robot& controller, const ProgramArguments& arguments) {
  const FlangeStated stated = arguments.flange.empty()     ? FlangeStated::no
                              : arguments.flange == "tool" ? FlangeStated::tool
                                                           : FlangeStated::last_link;
  refuse_if(
      why_flange_is_unclear(controller, arguments.controller, stated, arguments.tool_is_measured));
}

void refuse_other_arm(double nearest, const ModelPair& pair) {
  refuse_if(why_other_arm(pair, nearest));
}

std::string assumed_frames(const Robot& controller, const ProgramArguments& arguments,
                           const StatedFrames& tools, const StatedFrames& frames) {
  const auto otherwise = [](const std::vector<double>& numbers, const std::string& none) {
    return numbers.empty() ? none : fmt::format("{:g}", fmt::join(numbers, ", "));
  };
  const auto place = [](const StatedFrames& stated, const std::string& other) {
    if (stated.names.empty()) return other;
    const std::string rest = stated.in_base      ? ", in " + other
                             : stated.everywhere ? ""
                                                 : ", elsewhere " + other;
    return fmt::format("{}, as the program states{}", fmt::join(stated.names, ", "), rest);
  };
  const std::string last =
      arguments.flange == "tool" ? "the tool of " + arguments.controller + ", the flange"
                                 : fmt::format("R_{}, the flange", link_count(controller.chain));
  const bool has_external = std::ranges::any_of(
      joint_names(controller.chain), [](const JointName& name) { return name.column[0] == 'e'; });
  const std::string first = controller.ground_link ? "R_0, the table of the positioner"
                            : has_external         ? "R_0, before the external axis"
                                                   : "R_0, the robot foot";
  return "The tool is " +
         place(tools, arguments.tool_is_measured ? "that of " + arguments.robot
                                                 : otherwise(arguments.tool, last)) +
         "; the program's frame is " + place(frames, otherwise(arguments.base, first)) + ".";
}

void warn_of_doubts(Command& command, const std::vector<std::string>& doubts,
                    PredictionConditions& conditions) {
  for (const std::string& doubt : doubts) {
    command.warn(doubt);
    conditions.assumed.push_back(doubt + ".");
  }
}

void warn_of_station(Command& command, const std::vector<std::string>& not_applied) {
  for (const std::string& effect : not_applied)
    command.warn("not applied, because it belongs to the station, or may: " + effect);
}

}  // namespace armtrue::app
