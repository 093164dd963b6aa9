#include "armtrue/compensation/model_pair.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "armtrue/compensation/compensation.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// No two models of one arm are as far apart.
constexpr double kOtherArm = 50 * kMillimetre, kOtherFlange = 5 * kDegree;

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
    found.emplace_back("the payload changes nothing: no effect of the robot file follows it");
  if (has_force && !follows_force)
    found.emplace_back("the force changes nothing: no effect of the robot file follows it");
}

}  // namespace

std::string why_not_a_pair(const ModelPair& pair) {
  if (states_calibration(pair.controller) && !states_calibration(pair.robot))
    return pair.controller_name +
           ": states standard deviations, an uncertainty or effects, as a calibrated "
           "robot does, and " +
           pair.robot_name +
           " does not; exchange --robot and --controller, or every error would be "
           "doubled";
  const double turn = turn_of_last_frame(pair.robot, pair.controller);
  if (turn < kOtherFlange) return "";
  return fmt::format(
      "{} and {}: the last frames, R_{}, are turned by {:.0f} deg against each other about the "
      "same "
      "axis {}, so they are not the same flange: one of the files comes from another conversion of "
      "the arm; calibrate {} again, from {}",
      pair.robot_name, pair.controller_name, link_count(pair.controller.chain), turn / kDegree,
      joint_count(pair.controller.chain), pair.robot_name, pair.controller_name);
}

std::string why_flange_is_unclear(const Robot& controller, const std::string& name,
                                  FlangeStated stated, bool tool_is_measured) {
  const std::string last = fmt::format("R_{}", link_count(controller.chain));
  const bool is_identified = std::ranges::any_of(
      controller.std, [](const auto& entry) { return entry.first.starts_with("tool."); });
  if (is_identified && stated == FlangeStated::tool)
    return fmt::format(
        "--flange tool: the tool of {} was identified, so it holds where the reflector stood; "
        "convert the URDF again, which puts the flange into {}, and calibrate again",
        name, last);
  if (tool_is_measured || stated != FlangeStated::no || !may_hold_flange_in_tool(controller))
    return "";
  // Right angles; 0 has no sign.
  const Eigen::Array3d abc =
      (abc_from_rotation(controller.chain.tool.rotation).array() / kDegree).round() + 0.0;
  return fmt::format(
      "{}: tool is turned by right angles (a {:g}, b {:g}, c {:g} deg) behind a last link of "
      "zeros; earlier versions of convert-robot put the flange of a URDF there, but the program's "
      "poses are taken as those of {}. Convert the URDF again and calibrate again: the flange is "
      "then {}, and tool 0; or give {}--flange last-link if tool is where the reflector stood",
      name, abc[0], abc[1], abc[2], last, last,
      is_identified ? "" : "--flange tool if tool is the flange, ");
}

std::string why_other_arm(const ModelPair& pair, double nearest) {
  if (nearest < kOtherArm) return "";
  return fmt::format(
      "{} and {} are different arms: their flanges stand {:.4g} mm apart "
      "or more at every target; give two models of one arm, with the same "
      "first and last frame and zeros of the joints",
      pair.robot_name, pair.controller_name, nearest / kMillimetre);
}

namespace {

// An image has four corners or more that are not on one line, which show how the arm is turned.
bool shows_orientation(const Uncertainty& of) {
  return of.reading.orientation > 0 ||
         std::ranges::any_of(of.parameters, [](const std::string& name) {
           const Owner owner = Parameter(name).owner;
           return owner == Owner::camera || owner == Owner::board;
         });
}

}  // namespace

std::vector<std::string> doubts_of_models(const ModelPair& pair, const Campaign& visits,
                                          const std::string& predicted) {
  std::vector<std::string> found;
  if (states_calibration(pair.controller))
    found.push_back(fmt::format(
        "{} is itself calibrated: {} hold only if the controller runs it; if it runs a nominal "
        "model, give that as --controller",
        pair.controller_name, predicted));
  if (!pair.robot.uncertainty)
    found.push_back(pair.robot_name +
                    " does not state its uncertainty: it is not known which targets its readings "
                    "cover; calibrate and close-loop --robot-out write it");
  else if (!shows_orientation(*pair.robot.uncertainty))
    found.push_back(pair.robot_name +
                    " comes from points or distances: no orientation was measured, so corrections "
                    "of orientation follow from the joints alone");
  if (const std::vector<std::string> names = parameters_of_station(pair.robot); !names.empty())
    found.push_back(fmt::format(
        "{}: {} were identified without base or tool, so they may hold where the instrument and "
        "the reflector stood, and move the program by it; calibrate with identify: auto",
        pair.robot_name, fmt::join(names, ", ")));
  find_idle_loads(pair.robot, visits, found);
  return found;
}

std::vector<std::string> station_effects(const Robot& robot, bool tool_is_measured) {
  std::vector<std::string> names;
  for (const Effect& effect : robot.effects)
    if (!moves_program(effect, tool_is_measured))
      names.push_back(fmt::format("{} ({} follows {})", effect.name, to_string(effect.parameter),
                                  to_string(effect.driver)));
  return names;
}

}  // namespace armtrue
