#include <fmt/format.h>
#include <fmt/ranges.h>

#include "armtrue/calibration/constants_fit.h"
#include "armtrue/io/controller_fields.h"
#include "armtrue/io/output.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/ur_conf_io.h"
#include "armtrue/urdf/urdf_io.h"
#include "command_line.h"

using namespace armtrue;

namespace {

// A base or tool that moves farther was hardly identified as part of the arm.
constexpr double kNoticeable = 0.01 * kMillimetre;  // more than angles that are written as 3.1416
constexpr double kNoticeableTurn = 0.01 * kMilliradian;
constexpr double kLargeShift = 10 * kMillimetre, kLargeTurn = 1 * kDegree;

constexpr double kReferenceTemperature = 20;  // [deg C], of ISO 1

struct Arguments {
  std::string to, into, nominal, poses;
  UrdfEnds ends;
  UrdfKept kept;
  std::vector<double> counts_per_degree;
  std::optional<double> payload_kg, time_s, temperature_c;
};

void add_options(app::Command& command, Arguments& arguments) {
  command.add_input(
      "A robot: YAML, URDF, or calibration of Universal Robots (kinematics file or "
      "calibration.conf)");
  command.add_output(app::ProductKind::document);
  command
      .option(
          "--to", arguments.to,
          "yaml, which is JSON in a file that ends in .json, json, urdf, controller (with --into: "
          "a file of its maker), or fields (the table of the controller's own fields)")
      .required()
      .check(app::one_of({"yaml", "json", "urdf", "controller", "fields"}));
  command.option("--base", arguments.ends.base,
                 "Link of the URDF whose frame is R_A; its root if absent");
  command.option("--tip", arguments.ends.tip,
                 "Link of the URDF whose frame is that of the last link, the flange of programs; the "
                 "only end if absent");
  app::Option into = command.file(
      "--into", arguments.into,
      "URDF, or calibration of Universal Robots (kinematics file of the driver or "
      "calibration.conf), of the same arm: write it with the robot's geometry; only the "
      "origins of its joints change. With --to fields: what the controller holds now, "
      "$machine.dat of KUKA or SYSMAST.VA of FANUC");
  command.flag("--keep-base", arguments.kept.base, "With --into: the base stays as in the URDF")
      .needs(into);
  command.flag("--keep-tool", arguments.kept.tool, "With --into: the tool stays as in the URDF")
      .needs(into);
  command.file(
      "--nominal", arguments.nominal,
      "The nominal robot: of --to fields the model of the controller, of a calibration.conf "
      "the type by its DH parameters, such as ur5e.yaml");
  command
      .joints(
          "--counts-per-deg", arguments.counts_per_degree,
          "With SYSMAST.VA: how far the count of each encoder rises per deg of its axis, below 0 "
          "if it falls; separated by commas")
      .needs(into);
  command.file("--poses", arguments.poses,
               "Joint targets at which constants stand for the effects; the travel if absent");
  command.option("--payload-kg", arguments.payload_kg, "Payload there; 0 if absent")
      .check(app::payload_of_arm());
  command.option("--t-s", arguments.time_s, "Time since the start of the campaign; 0 if absent");
  command.option("--temp-c", arguments.temperature_c, "Temperature of all sensors; 20 if absent")
      .check(app::temperature_of_arm());
}

bool is_xml(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // behind a BOM, too
  return first != std::string::npos && text[first] == '<';
}

void explain_base(app::Command& command, const std::string& text, const std::string& file,
                  const UrdfEnds& ends) {
  for (const std::string& link : frames_beside_base(text, file, ends))
    command.warn(file + ": R_A is the frame of '" +
                 (ends.base.empty() ? "the root link" : ends.base) + "'; '" + link +
                 "' stands beside it, moved or turned; if the controller's poses are in '" + link +
                 "', give --base " + link);
}

// Programs speak of the flange in R_0, which of a URDF are --tip and --base.
void explain_flange(app::Command& command, const Robot& robot, const std::string& text,
                    const std::string& file, const UrdfEnds& ends) {
  const Eigen::Vector3d foot = foot_beside_base(text, file, ends) / kMillimetre;
  if (foot.norm() > kNoticeable / kMillimetre)
    command.warn(fmt::format(
        "{}: R_0, the foot of programs, stands at {:.4g}, {:.4g}, {:.4g} mm of the frame of --base, "
        "because link 1 alone does not lead from there to axis 1: for poses in the frame of --base "
        "give compensate --base {:.10g},{:.10g},{:.10g},0,0,0",
        file, foot.x(), foot.y(), foot.z(), -foot.x(), -foot.y(), -foot.z()));
  const std::string tool0 = tool0_beside_tip(text, file, ends);
  if (!tool0.empty())
    command.warn(fmt::format(
        "{}: R_{}, the flange of programs, is the frame of '{}'; '{}' stands elsewhere; if it is the "
        "flange of the controller, give --tip {}",
        file, link_count(robot.chain), ends.tip.empty() ? "the end of the arm" : ends.tip, tool0,
        tool0));
}

void explain_two_arms(app::Command& command, const Robot& robot, const std::string& file) {
  if (!robot.ground_link) return;
  const std::vector<Link>& links = robot.chain.links;
  const auto ground = static_cast<size_t>(*robot.ground_link);
  const auto back = std::count_if(links.begin(), links.begin() + *robot.ground_link, is_driven);
  command.warn(
      fmt::format("{}: two arms as one chain: joints 1 to {} lead from --base back to '{}', which "
                  "stands on the ground, and joints {} to {} from there to --tip",
                  file, back, links[ground].name, back + 1, joint_count(robot.chain)));
}

void warn_of_travel(app::Command& command, const std::string& text, const std::string& file,
                    const UrdfEnds& ends) {
  const std::vector<std::string> links = links_without_travel(text, file, ends);
  if (links.empty()) return;
  command.warn(
      fmt::format("{}: states no travel of {} (limits of 0): add min_deg and max_deg, or poses are "
                  "planned over "
                  "whole turns",
                  file, fmt::join(links, ", ")));
}

void warn_of_shift(app::Command& command, const char* what, const char* where,
                   const FrameShift& shift) {
  if (shift.distance < kLargeShift && shift.angle < kLargeTurn) return;
  command.warn(
      fmt::format("the {} moves by {:.4g} mm and {:.3g} deg; if that is where the {} "
                  "stood, and not the robot's own, give --keep-{}",
                  what, shift.distance / kMillimetre, shift.angle / kDegree, where, what));
}

std::string into_urdf(app::Command& command, const Robot& robot, const Arguments& arguments) {
  Source source(arguments.into);
  const std::string document = source.read_all();
  const PatchedUrdf patched =
      is_ur_calibration(document)
          ? write_into_ur_calibration(robot, document, source.name(), arguments.kept)
          : write_into_urdf(robot, document, source.name(), arguments.ends, arguments.kept);
  warn_of_shift(command, "base", "instrument", patched.base);
  warn_of_shift(command, "tool", "reflector", patched.tool);
  const FrameShift& left = patched.tool_left_out;
  if (left.distance > kNoticeable || left.angle > kNoticeableTurn)
    command.warn(fmt::format(
        "{}: '{}' turns with the last joint, so no origin can hold the tool: {:.4g} mm and {:.3g} deg "
        "of it are not written; if they belong to the robot, add a link that is fixed behind '{}' and "
        "name it by --tip, else give --keep-tool",
        source.name(), left.of_link, left.distance / kMillimetre, left.angle / kDegree,
        left.of_link));
  return patched.text;
}

Context conditions_of(const Arguments& arguments) {
  Context conditions;
  conditions.payload_kg = arguments.payload_kg.value_or(0);
  conditions.time_s = arguments.time_s.value_or(0);
  conditions.temperature_c.fill(arguments.temperature_c.value_or(kReferenceTemperature));
  return conditions;
}

// The visits over which constants stand for the arm, and what a message says of them.
struct Visits {
  ConstantsVisits visits;
  std::string words;
};

Visits visits_of(const Robot& arm, const Arguments& arguments) {
  const Context conditions = conditions_of(arguments);
  Visits result;
  if (arguments.poses.empty()) {
    result.visits = visits_of_travel(arm, conditions);
  } else {
    std::vector<JointVector> q;
    for (const JointTarget& target : read_joint_targets(arguments.poses, joint_names(arm.chain)))
      q.push_back(target.q);
    result.visits = visits_at(arm, q, conditions);
  }
  result.words = fmt::format("{} poses of {}", result.visits.contexts.size(),
                             arguments.poses.empty() ? "the travel" : arguments.poses);
  const auto add = [&](DriverKind kind, const std::string& words) {
    for (const Effect& effect : arm.effects)
      if (effect.driver.involves(kind)) {
        result.words += words;
        return;
      }
  };
  add(DriverKind::payload, fmt::format(", {:g} kg (--payload-kg)", conditions.payload_kg));
  add(DriverKind::time, fmt::format(", {:g} s (--t-s)", conditions.time_s));
  add(DriverKind::temperature,
      fmt::format(", {:g} deg C (--temp-c)", conditions.temperature_c.front()));
  return result;
}

std::string in_mm(const ModelDistance& distance) {
  return fmt::format("{:.4g} mm, largest {:.4g} mm", distance.mean / kMillimetre,
                     distance.max / kMillimetre);
}

bool is_measured(const Effect& effect) { return effect.driver.involves(DriverKind::motor_torque); }

// The arm alone: effects of the station, and of the tool that carried the reflectors, are not its.
Robot arm_of(app::Command& command, const Robot& robot) {
  std::vector<std::string> left, measured;
  for (const Effect& effect : robot.effects) {
    if (!moves_program(effect, false))
      left.push_back(effect.name);
    else if (is_measured(effect))
      measured.push_back(effect.name);
  }
  if (!left.empty())
    command.warn(
        fmt::format("effects of the instrument or the measured tool are not in the "
                    "constants: {}",
                    fmt::join(left, ", ")));
  if (!measured.empty())
    command.warn(
        fmt::format("effects of measured motor torques, which are not known at other poses, "
                    "are not in the constants: {}",
                    fmt::join(measured, ", ")));
  Robot arm = without_station_effects(robot, false);
  std::erase_if(arm.effects, is_measured);
  return arm;
}

ConstantsFit fit(const Robot& arm, const KinematicChain& from, const std::vector<int>& free,
                 const ConstantsVisits& visits, const std::string& file) {
  try {
    return fit_constants(arm, from, free, visits);
  } catch (const std::invalid_argument& error) {
    throw InputError(file + ": " + error.what());
  }
}

// The robot as a file without effects holds it best.
Robot with_constants_alone(app::Command& command, Robot robot, const std::string& file,
                           const Arguments& arguments) {
  Robot arm = arm_of(command, robot);
  robot.chain = arm.chain;
  robot.effects.clear();
  if (arm.effects.empty()) {
    if (!arguments.poses.empty())
      command.warn(file + ": has no effects of the arm, so --poses changes nothing");
    return robot;
  }
  const auto [visits, words] = visits_of(arm, arguments);
  const ConstantsFit fitted = fit(arm, arm.chain, link_parameters(arm.chain), visits, file);
  command.warn(
      fmt::format("the constants that are written stand for the effects, too: over {} they miss "
                  "the arm with its "
                  "effects by {}; those of {} alone miss it by {}",
                  words, in_mm(fitted.after), file, in_mm(fitted.before)));
  robot.chain = fitted.chain;
  return robot;
}

Robot nominal_robot(app::Command& command, const Arguments& arguments, const std::string& why) {
  if (arguments.nominal.empty()) throw InputError(why);
  return command.read_robot(arguments.nominal).robot;
}

// Zero offsets are all that mastering holds: they stand for lengths and effects as far as they can.
std::string controller_fields(app::Command& command, const Robot& robot, const std::string& file,
                              const Arguments& arguments) {
  const Robot nominal = nominal_robot(
      command, arguments,
      "--to fields: give the model of the controller as --nominal; the fields hold what changes");
  std::optional<Mastering> mastering;
  if (!arguments.into.empty()) {
    Source source(arguments.into);
    mastering = read_mastering(source.read_all(), source.name());
  }
  const Robot arm = arm_of(command, robot);
  app::require_same_joints(arm, file, nominal, arguments.nominal);
  KinematicChain from = nominal.chain;
  std::vector<int> free;
  for (int zero : zero_offsets(arm.chain))
    if (!is_of_positioner(arm, zero)) free.push_back(zero);
  if (arm.ground_link)  // its own fields hold all of a positioner
    std::copy_n(arm.chain.links.begin(), *arm.ground_link + 1, from.links.begin());
  const auto [visits, words] = visits_of(arm, arguments);
  const ConstantsFit fitted = fit(arm, from, free, visits, file);
  command.warn(fmt::format(
      "zero offsets alone bring the model of the controller from {} to {} of the arm, over {}; "
      "lengths, twists and effects are not in them",
      in_mm(fitted.before), in_mm(fitted.after), words));
  Robot with_zeros = arm;
  with_zeros.chain = fitted.chain;
  return write_controller_fields(with_zeros, nominal.chain, mastering, arguments.counts_per_degree);
}

std::string into_conf(app::Command& command, const Robot& robot, const Arguments& arguments,
                      const std::string& document, const std::string& name) {
  const Robot nominal = nominal_robot(command, arguments,
                                      name +
                                          ": is added to the DH parameters of the type; give its "
                                          "robot file as --nominal, such as ur5e.yaml");
  const PatchedUrdf patched = write_into_ur_conf(robot, document, name, nominal, arguments.nominal);
  const auto leave = [&](const char* what, const FrameShift& left) {
    if (left.distance > kNoticeable || left.angle > kNoticeableTurn)
      command.warn(
          fmt::format("{}: has no place for the {}: {:.4g} mm and {:.3g} deg are not written; {}",
                      name, what, left.distance / kMillimetre, left.angle / kDegree,
                      "measure frame and tool of the program anew with the new file"));
  };
  leave("foot beside axis 1", patched.base);
  leave("flange beside axis 6", patched.tool_left_out);
  return patched.text;
}

std::string into_controller(app::Command& command, const Robot& robot, const Arguments& arguments) {
  Source source(arguments.into);
  const std::string document = source.read_all();
  if (is_ur_conf(document)) return into_conf(command, robot, arguments, document, source.name());
  if (is_ur_calibration(document)) return into_urdf(command, robot, arguments);
  throw InputError(source.name() +
                   ": is no file of a controller that is known: calibration.conf or the kinematics "
                   "file of Universal Robots; for KUKA and FANUC give --to fields");
}

Robot read_any(app::Command& command, const std::string& text, const std::string& file,
               const Arguments& arguments) {
  if (is_xml(text)) {
    const Robot robot = parse_urdf(text, file, arguments.ends);
    explain_base(command, text, file, arguments.ends);
    explain_flange(command, robot, text, file, arguments.ends);
    explain_two_arms(command, robot, file);
    warn_of_travel(command, text, file, arguments.ends);
    return robot;
  }
  if (is_ur_calibration(text)) return parse_ur_calibration(text, file);
  if (!is_ur_conf(text)) return parse_robot(text, file);
  const Robot nominal = nominal_robot(command, arguments,
                                      file +
                                          ": is added to the DH parameters of the type; give its "
                                          "robot file as --nominal, such as ur5e.yaml");
  return parse_ur_conf(text, file, nominal, arguments.nominal);
}

void check_usage(const app::Command& command, const Arguments& arguments) {
  if (arguments.to == "urdf" && is_json_file(command.output))
    throw app::UsageError("-o: '" + command.output +
                          "' ends in .json, and a URDF is XML: end it in .urdf, or give --to json");
  if (arguments.to == "controller" && arguments.into.empty())
    throw app::UsageError(
        "--to controller: name the file of the controller as --into; its other lines stay");
}

int run(app::Command& command, const Arguments& arguments) {
  check_usage(command, arguments);
  Source source(command.input);
  const std::string text = source.read_all();
  const bool writes_into = arguments.to != "yaml" && arguments.to != "json";
  if (!arguments.into.empty() && (is_xml(text) || !writes_into))
    throw InputError(
        "--into writes a robot file into another file: it needs --to urdf, controller or fields, "
        "and "
        "YAML as input");
  const Robot robot = read_any(command, text, source.name(), arguments);
  if (arguments.to == "json") {
    write_output(command.output, write_robot(robot).json());
    return app::kSuccess;
  }
  if (arguments.to == "yaml") {
    write_output(command.output, write_robot(robot));
    return app::kSuccess;
  }
  if (arguments.to == "fields") {
    write_output(command.output, controller_fields(command, robot, source.name(), arguments));
    return app::kSuccess;
  }
  if (robot.ground_link)
    throw InputError(source.name() +
                     ": a URDF is written of an arm alone, and this robot is two arms or has a "
                     "positioner that carries the part; keep it as YAML, which all commands read");
  std::string lost;
  for (const std::string& key : lost_in_urdf(robot)) lost += (lost.empty() ? "" : ", ") + key;
  if (!lost.empty() && arguments.to == "urdf") command.warn("URDF cannot hold: " + lost);
  const Robot alone = with_constants_alone(command, robot, source.name(), arguments);
  write_output(command.output, arguments.to == "controller"
                                   ? into_controller(command, alone, arguments)
                               : arguments.into.empty() ? write_urdf(alone)
                                                        : into_urdf(command, alone, arguments));
  return app::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  app::Command command("convert-robot",
                       "Convert a robot between its YAML file, URDF and files of controllers.",
                       "convert-robot robot.yaml --to urdf > robot.urdf");
  Arguments arguments;
  add_options(command, arguments);
  return command.run(argc, argv, [&] { return run(command, arguments); });
}
