#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Sign of the last motion of each joint: -1 or 1; 0 if unknown.
using Direction = std::array<std::int8_t, kMaxJoints>;

inline constexpr int kMaxTemperatures = 8;

/// The state of robot and surroundings at one reading, without the reading itself.
struct Context {
  JointVector q = JointVector::Zero(kMaxJoints);  ///< encoder values [rad or m]
  Direction arrival{};                            ///< direction of arrival; 0: unknown
  /// Travel of each joint since its last reversal, with the sign of its motion [rad or m].
  JointVector stroke = JointVector::Zero(kMaxJoints);
  double time_s = 0;      ///< since the start of the campaign
  /// Name of the session, a view of the campaign's names. An effect takes an empty or unknown one
  /// as the last of Driver::sessions.
  std::string_view session{};
  double payload_kg = 0;  ///< carried at the measured frame, beyond `bodies`
  std::array<double, kMaxJoints> motor_torque_nm{};      ///< by joint, as measured
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();     ///< on the tool, axes of R_A
  std::array<double, kMaxTemperatures> temperature_c{};  ///< by sensor, in the campaign's order
};

}  // namespace armtrue
