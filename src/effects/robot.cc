#include "armtrue/effects/robot.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

// Posture and loads act on the foot of the arm; a clock and a thermometer do not tell whose drift
// it is.
bool is_of_the_arm(DriverKind kind) {
  switch (kind) {
    case DriverKind::joint_angle:
    case DriverKind::gravity_torque:
    case DriverKind::motor_torque:
    case DriverKind::arrival:
    case DriverKind::stroke:
    case DriverKind::payload:
    case DriverKind::force:
    case DriverKind::moment:
    case DriverKind::tool_weight:
    case DriverKind::gravity_direction:
      return true;
    case DriverKind::time:
    case DriverKind::session:
    case DriverKind::temperature:
    case DriverKind::constant:
    case DriverKind::range:
    case DriverKind::azimuth:
    case DriverKind::elevation:
    case DriverKind::incidence:
    case DriverKind::place:
      break;
  }
  return false;
}

}  // namespace

bool is_of_positioner(const Robot& robot, int parameter) {
  return robot.ground_link && parameter < link_parameter(*robot.ground_link + 1, LinkParameter{});
}

bool places_positioner(const Robot& robot, int parameter) {
  if (parameter < kFirstLinkParameter || !is_of_positioner(robot, parameter)) return false;
  int axis = *robot.ground_link;
  while (axis > 0 && joint_of_link(robot.chain, axis) < 0) --axis;
  const LinkParameter kind = kind_of_parameter(parameter);
  return link_of_parameter(parameter) > axis ||
         (link_of_parameter(parameter) == axis &&
          (kind == LinkParameter::theta || kind == LinkParameter::r));
}

std::vector<int> lengths_of_arm(const Robot& robot) {
  const KinematicChain& chain = robot.chain;
  const std::vector<JointName> names = joint_names(chain);
  std::vector<int> lengths;
  for (int link = 0; link < link_count(chain); ++link) {
    const int joint = joint_of_link(chain, link), d = link_parameter(link, LinkParameter::d);
    if (is_of_positioner(robot, d) || (joint >= 0 && names[joint].is_external())) continue;
    lengths.push_back(d);
    if (!is_prismatic(chain.links[link])) lengths.push_back(link_parameter(link, LinkParameter::r));
  }
  return lengths;
}

Eigen::Vector3d upwards(const Robot& robot) {
  const double g = robot.gravity.norm();
  if (g == 0 || robot.ground_link) return Eigen::Vector3d::UnitZ();
  return robot.chain.base.rotation * (-robot.gravity / g);
}

bool knows_instrument(const Robot& robot) {
  if (robot.ground_link) return false;
  double reach = robot.chain.tool.translation.norm();
  for (const Link& link : robot.chain.links) {
    reach += std::abs(link.d) + std::abs(link.r);
    if (is_prismatic(link)) reach += std::max(std::abs(link.min), std::abs(link.max));
  }
  return robot.instrument || robot.chain.base.translation.norm() > reach;
}

bool moves_program(const Effect& effect, bool tool_is_measured) {
  if (effect.may_be_instrument) return false;
  const Owner owner = owner_of(effect);
  if (owner == Owner::tool) return tool_is_measured;
  if (owner == Owner::base)
    return is_of_the_arm(effect.driver.kind) ||
           (effect.driver.factor && is_of_the_arm(*effect.driver.factor));
  return !moves_reading_alone(owner);
}

Robot without_station_effects(Robot robot, bool tool_is_measured) {
  for (const Effect& effect : robot.effects) {
    if (effect.mean == 0) continue;
    const Parameter& own = effect.parameter;
    if (is_arm_scale(own) || is_instrument_parameter(own, InstrumentParameter::scale))
      for (int k : lengths_of_arm(robot))
        move_parameter(robot.chain, k, *parameter_value(robot.chain, k) * effect.mean);
    else if (const auto parameter = find_parameter(robot.chain, own))
      move_parameter(robot.chain, *parameter, effect.mean);
  }
  std::erase_if(robot.effects,
                [&](const Effect& effect) { return !moves_program(effect, tool_is_measured); });
  return robot;
}

bool states_calibration(const Robot& robot) {
  return robot.uncertainty || !robot.std.empty() || !robot.effects.empty();
}

}  // namespace armtrue
