#pragma once

#include <algorithm>

#include "armtrue/effects/effect.h"

namespace armtrue {

/// Whether joint angles and payload alone determine the value of a driver. Other drivers differ
/// between visits of a pose.
inline bool is_of_posture(DriverKind kind) {
  switch (kind) {
    case DriverKind::motor_torque:
    case DriverKind::arrival:
    case DriverKind::stroke:
    case DriverKind::time:
    case DriverKind::session:
    case DriverKind::temperature:
    case DriverKind::force:
      return false;
    case DriverKind::joint_angle:
    case DriverKind::gravity_torque:
    case DriverKind::payload:
    case DriverKind::moment:
    case DriverKind::constant:
    case DriverKind::tool_weight:
    case DriverKind::range:
    case DriverKind::azimuth:
    case DriverKind::elevation:
    case DriverKind::incidence:
    case DriverKind::place:
    case DriverKind::gravity_direction:
      break;
  }
  return true;
}

/// The same for an effect; for a family, whether it holds for all members.
inline bool is_of_posture(const Effect& effect) {
  const Driver& driver = effect.driver;
  if (!effect.members.empty())
    return std::ranges::all_of(effect.members,
                               [](const Effect& member) { return is_of_posture(member); });
  return is_of_posture(driver.kind) && (!driver.factor || is_of_posture(*driver.factor));
}

}  // namespace armtrue
