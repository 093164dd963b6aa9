#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// The quantity that a parameter follows from one reading to the next.
enum class DriverKind {
  joint_angle,     ///< encoder angle of one joint, or of two (a series of both)
  gravity_torque,  ///< torque of gravity about the axis of one joint [N m]
  motor_torque,    ///< measured torque of one joint's motor, on the side of the arm [N m]
  arrival,         ///< direction in which one joint came to its pose: -1, 0, 1
  time,            ///< [s]
  temperature,     ///< of one sensor [deg C]
  payload,         ///< [kg]
  force,           ///< generalised force of the tool load on the parameter itself [N m or N]
  moment,          ///< generalised force of gravity on the parameter itself [N m or N]
  position,        ///< the reading itself; only for instrument.scale
};

struct Driver {
  DriverKind kind = DriverKind::joint_angle;
  int joint = -1;         ///< 0-based; joint_angle, the torques and arrival
  int second_joint = -1;  ///< 0-based; joint_angle of two joints, arrival as a factor
  std::string where;      ///< temperature: the sensor's name, as in the column temp_<where>_c
  /// A second driver, whose value multiplies the shape of the first: arrival, time, temperature
  /// (from 20 deg C on, the reference of ISO 1), payload or force.
  std::optional<DriverKind> factor{};

  /// Two joint angles, each with a shape of its own.
  bool is_pair() const { return second_joint >= 0 && !factor; }
  /// Whether one of the two is of this kind.
  bool involves(DriverKind which) const { return kind == which || factor == which; }

  bool operator==(const Driver&) const = default;
};

/// As in the files: `joint-angle 4`, `joint-angle 2,4`, `gravity-torque 2`, `temperature air`,
/// `joint-angle 3 * payload`, ...
std::string to_string(const Driver& driver);
std::optional<Driver> parse_driver(std::string_view text);

/// SI unit of the value of a driver that moves a parameter measured in `parameter`, for messages:
/// "rad", "N m", "s", ...; empty if it has none.
std::string unit_of(DriverKind kind, ParameterUnit parameter);

}  // namespace armtrue
