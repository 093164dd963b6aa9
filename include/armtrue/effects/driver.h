#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// The quantity on which a parameter depends.
enum class DriverKind {
  joint_angle,     ///< encoder value of one joint [rad, m], or of two joints (a series of products)
  gravity_torque,  ///< torque of gravity about the axis of one joint [N m], or force along it [N]
  motor_torque,    ///< measured torque of the motor of one joint, after the gear [N m]
  arrival,         ///< direction in which one joint came to its pose: -1, 0, 1
  stroke,       ///< way of one joint since its last reversal, with the sign of its motion [rad, m]
  time,         ///< [s]
  temperature,  ///< of one sensor [deg C]
  payload,      ///< [kg]
  force,        ///< generalised force of the tool load on the parameter itself [N m or N]
  moment,       ///< generalised force of gravity on the parameter itself [N m or N]
  constant,     ///< 1: an error of every reading; only for parameters of the instrument
  tool_weight,  ///< torque of gravity about one joint by 1 kg at the measured frame [N m]
  range,        ///< distance of the measured frame from the instrument, of a wire its length [m]
  azimuth,      ///< of the line of sight, about the vertical through the instrument [rad]
  elevation,    ///< of the line of sight, above the horizontal [rad]
  incidence,    ///< angle between the line of sight and the z axis of the measured frame [rad]
  place,        ///< position of the measured frame in R_0 [m]; only for a polynomial
  gravity_direction,  ///< unit vector of gravity in the axes of the last link: three values
  session,  ///< number of the session in Driver::sessions; an unknown one counts as the last
};

/// The driver of an effect.
struct Driver {
  DriverKind kind = DriverKind::joint_angle;
  int joint = -1;         ///< 0-based; of joint_angle, torques, arrival, stroke, tool_weight
  int second_joint = -1;  ///< 0-based; of a joint_angle of two joints, or of the factor
  std::string where;      ///< of a temperature: name of the sensor, as in the column temp_<where>_c
  /// A second driver, whose value multiplies the shape of the first: arrival, time, temperature
  /// (minus 20 deg C, the reference of ISO 1), payload, force or, if the first is time or session,
  /// gravity_torque or tool_weight.
  std::optional<DriverKind> factor{};
  /// Of `session`: the sessions of the calibration, in their order.
  std::vector<std::string> sessions{};

  /// Whether the driver is two joint angles, each with its own shape.
  bool is_pair() const { return second_joint >= 0 && !factor; }
  bool involves(DriverKind which) const { return kind == which || factor == which; }
  bool follows_course() const {
    return involves(DriverKind::time) || involves(DriverKind::session);
  }

  bool operator==(const Driver&) const = default;
};

/// Whether a driver of this kind is an angle, or the travel of a prismatic joint.
bool is_angle_or_travel(DriverKind kind);

/// Whether its value is the travel of a prismatic joint [m], not an angle.
bool is_travel(const Driver& driver, const KinematicChain& chain);

/// Whether its value is a length [m]: such a travel, or a range.
bool is_length(const Driver& driver, const KinematicChain& chain);

/// As in the files: `joint-angle 4`, `joint-angle 2,4`, `gravity-torque 2`, `temperature air`,
/// `joint-angle 3 * payload`, ...
std::string to_string(const Driver& driver);
std::optional<Driver> parse_driver(std::string_view text);

/// SI unit of the value of a driver, for messages: "rad", "N m", "s", ...; empty if it has none.
/// `parameter`: unit of the parameter that it moves. `joint`: of the driver or, if `kind` is a
/// factor, of the factor.
std::string unit_of(const KinematicChain& chain, DriverKind kind, int joint,
                    ParameterUnit parameter);

}  // namespace armtrue
