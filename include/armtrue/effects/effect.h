#pragma once

#include <array>
#include <string>
#include <vector>

#include "armtrue/effects/driver.h"
#include "armtrue/effects/shape.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// One identified number of an effect, in SI units of parameter per shape of driver.
struct Coefficient {
  std::string name;  ///< "c"; "sin", "cos"; "rx", ...
  double value = 0;
  double std = 0;  ///< 0 if it was not identified here
  /// 95 % interval; takes the masses of the robot file as exact.
  std::array<double, 2> ci95{0, 0};
};

/// A parameter that is not constant:
///     parameter(context) = constant + sum_k c_k shape_k(driver(context)).
/// `parameter` is the name of one parameter, or of a group of six (`base`, `tool`), each of which
/// then has its own coefficients, in the order x y z rx ry rz, and follows its own generalised
/// force; with the driver `moment` a group is its rotation vector, which follows the vector of the
/// moment with one common coefficient. A factor of the driver multiplies every shape_k.
struct Effect {
  std::string name;
  std::string parameter;
  Driver driver;
  Shape shape;
  std::vector<Coefficient> coefficients;
};

/// Whether both have one parameter and one driver.
inline bool same_place(const Effect& a, const Effect& b) {
  return a.parameter == b.parameter && a.driver == b.driver;
}

/// Whether both have one parameter, one driver and one shape; coefficients may differ.
inline bool same_form(const Effect& a, const Effect& b) {
  return same_place(a, b) && a.shape == b.shape;
}

/// Whether an effect's parameter stands for the six components of a pose.
inline bool is_group(const std::string& parameter) {
  return parameter == "base" || parameter == "tool";
}

/// What an effect's parameter is measured in; radian of a group, whose coefficients have units of
/// their own unless the moment turns it.
ParameterUnit unit_of_parameter(const KinematicChain& chain, const std::string& parameter);

/// The reason why no parameter of this name can follow the driver in this shape, with the remedy;
/// empty if it can.
std::string why_invalid(const std::string& parameter, const Driver& driver, const Shape& shape);

}  // namespace armtrue
