#include "conversion_outputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "armtrue/calibration/constants_fit.h"
#include "armtrue/io/controller_fields.h"
#include "armtrue/io/joint_target_io.h"
#include "armtrue/io/source.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/urdf/ur_calibration_io.h"
#include "armtrue/urdf/ur_conf_io.h"
#include "armtrue/urdf/urdf_io.h"

namespace armtrue::app {
namespace {

// A base or tool that moves farther was hardly identified as part of the arm.
constexpr double kNoticeable = 0.01 * kMillimetre;  // more than angles that are written as 3.1416
constexpr double kNoticeableTurn = 0.01 * kMilliradian;
constexpr double kLargeShift = 10 * kMillimetre, kLargeTurn = 1 * kDegree;

constexpr double kReferenceTemperature = 20;  // [deg C], of ISO 1

void warn_of_shift(Command& command, const char* what, const char* where, const FrameShift& shift) {
  if (shift.distance < kLargeShift && shift.angle < kLargeTurn) return;
  command.warn(
      fmt::format("the {} moves by {:.4g} mm and {:.3g} deg; if that is where the {} "
                  "stood, and not the robot's own, give --keep-{}",
                  what, shift.distance / kMillimetre, shift.angle / kDegree, where, what));
}

Context conditions_of(const ConversionArguments& arguments) {
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

Visits visits_of(Command& command, const Robot& arm, const ConversionArguments& arguments) {
  const Context conditions = conditions_of(arguments);
  Visits result;
  if (arguments.poses.empty()) {
    result.visits = visits_of_travel(arm, conditions);
  } else {
    std::vector<JointVector> q;
    const std::vector<JointTarget> targets =
        read_joint_targets(arguments.poses, joint_names(arm.chain));
    warn_beyond_travel(command, arguments.poses, targets, arm.chain);
    for (const JointTarget& target : targets) q.push_back(target.q);
    result.visits = visits_at(arm, q, conditions);
  }
  result.words = fmt::format("{} of {}{}", counted(result.visits.contexts.size(), "pose"),
                             arguments.poses.empty() ? "the travel" : arguments.poses,
                             conditions_in_words(arm, conditions));
  return result;
}

std::string in_mm(const ModelDistance& distance) {
  return fmt::format("{:.4g} mm, largest {:.4g} mm", distance.mean / kMillimetre,
                     distance.max / kMillimetre);
}

// The arm alone; `command` says what is left out.
Robot arm_of(Command& command, const Robot& robot) {
  warn_of_all(command, not_in_constants(robot));
  return arm_of_constants(robot);
}

ConstantsFit fit(const Robot& arm, const KinematicChain& from, const std::vector<int>& free,
                 const ConstantsVisits& visits, const std::string& file) {
  try {
    return fit_constants(arm, from, free, visits);
  } catch (const std::invalid_argument& error) {
    throw InputError(file + ": " + error.what());
  }
}

std::string into_conf(Command& command, const Robot& robot, const ConversionArguments& arguments,
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

}  // namespace

Robot with_constants_alone(Command& command, const Robot& given, const std::string& file,
                           const ConversionArguments& arguments) {
  const Robot arm = arm_of(command, given);
  Robot robot = given;
  robot.chain = arm.chain;
  robot.effects.clear();
  if (arm.effects.empty()) {
    if (!arguments.poses.empty())
      command.warn(file + ": has no effects of the arm, so --poses changes nothing");
    return robot;
  }
  const auto [visits, words] = visits_of(command, arm, arguments);
  const ConstantsFit fitted = fit(arm, arm.chain, link_parameters(arm.chain), visits, file);
  command.warn(
      fmt::format("the constants that are written stand for the effects, too: over {} they miss "
                  "the arm with its "
                  "effects by {}; those of {} alone miss it by {}",
                  words, in_mm(fitted.after), file, in_mm(fitted.before)));
  robot.chain = fitted.chain;
  return robot;
}

std::string controller_fields(Command& command, const Robot& robot, const std::string& file,
                              const ConversionArguments& arguments) {
  const Robot nominal = nominal_robot(
      command, arguments,
      "--to fields: give the model of the controller as --nominal; the fields hold what changes");
  std::optional<Mastering> mastering;
  if (!arguments.into.empty()) {
    Source source(arguments.into);
    mastering = read_mastering(source.read_all(), source.name());
  }
  const Robot arm = arm_of(command, robot);
  require_same_joints(arm, file, nominal, arguments.nominal);
  KinematicChain from = nominal.chain;
  std::vector<int> free;
  for (int zero : zero_offsets(arm.chain))
    if (!is_of_positioner(arm, zero)) free.push_back(zero);
  if (arm.ground_link)  // its own fields hold all of a positioner
    std::copy_n(arm.chain.links.begin(), *arm.ground_link + 1, from.links.begin());
  const auto [visits, words] = visits_of(command, arm, arguments);
  const ConstantsFit fitted = fit(arm, from, free, visits, file);
  command.warn(fmt::format(
      "zero offsets alone bring the model of the controller from {} to {} of the arm, over {}; "
      "lengths, twists and effects are not in them",
      in_mm(fitted.before), in_mm(fitted.after), words));
  Robot with_zeros = arm;
  with_zeros.chain = fitted.chain;
  return write_controller_fields(with_zeros, nominal.chain, mastering, arguments.counts_per_degree);
}

std::string into_urdf(Command& command, const Robot& robot, const ConversionArguments& arguments) {
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
    command.warn(
        fmt::format("{}: '{}' turns with the last joint, so no origin can hold the tool: {:.4g} mm "
                    "and {:.3g} deg "
                    "of it are not written; if they belong to the robot, add a link that is fixed "
                    "behind '{}' and "
                    "name it by --tip, else give --keep-tool",
                    source.name(), left.of_link, left.distance / kMillimetre, left.angle / kDegree,
                    left.of_link));
  return patched.text;
}

std::string into_controller(Command& command, const Robot& robot,
                            const ConversionArguments& arguments) {
  Source source(arguments.into);
  const std::string document = source.read_all();
  if (is_ur_conf(document)) return into_conf(command, robot, arguments, document, source.name());
  if (is_ur_calibration(document)) return into_urdf(command, robot, arguments);
  throw InputError(source.name() +
                   ": is no file of a controller that is known: calibration.conf or the kinematics "
                   "file of Universal Robots; for KUKA and FANUC give --to fields");
}

}  // namespace armtrue::app
