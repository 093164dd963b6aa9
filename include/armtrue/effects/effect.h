#pragma once

#include <array>
#include <optional>
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

/// One cause that acts in many places, such as gravity on the stiffness of every joint. The
/// coefficients of its members are about 0, each with its typical size times a common factor as
/// prior deviation.
struct Family {
  std::string name;
  double typical = 0;  ///< typical size of each coefficient of the effect, in its unit
};

/// A parameter that is not constant:
///     parameter(context) = constant + sum_k c_k shape_k(driver(context)).
/// `parameter` is the name of one parameter, or of a group: the six of `base` or `tool`, in the
/// order x y z rx ry rz, the place x y z of a `target <name>`, or `instrument.point`, the error x y
/// z of the points that the instrument reads. Each of a group has its own
/// coefficients and follows its own generalised force; with the driver `moment` a group is its
/// rotation vector, which follows the vector of the moment with one common coefficient. A factor of
/// the driver multiplies every shape_k.
struct Effect {
  std::string name;
  std::string parameter;
  Driver driver;
  Shape shape;
  std::vector<Coefficient> coefficients;
  std::optional<Family> family{};  ///< that the effect belongs to
  /// Whether the readings left open that the instrument errs in place of the arm. The effect then
  /// stands for what the instrument reads, and moves no program.
  bool may_be_instrument = false;
  /// Mean of the effect over the poses of its calibration, of one that may be the instrument's: the
  /// constants stand for the arm only together with it [SI].
  double mean = 0;
  /// The effects that make up a whole family, whose coefficients stand here one after the other;
  /// `parameter` is then the name of the family. Only a search has such effects.
  std::vector<Effect> members{};
};

/// Whether both have one parameter and one driver.
inline bool same_place(const Effect& a, const Effect& b) {
  return a.parameter == b.parameter && a.driver == b.driver;
}

/// Whether both have one parameter, one driver and one shape; coefficients may differ.
inline bool same_form(const Effect& a, const Effect& b) {
  return same_place(a, b) && a.shape == b.shape;
}

inline constexpr const char* kPointOfInstrument = "instrument.point";

/// Number of the parameters that an effect's parameter stands for: 6 of a pose, 3 of a point.
int group_size(const std::string& parameter);
inline bool is_group(const std::string& parameter) { return group_size(parameter) > 1; }

/// Index of the first of them; nothing if the chain has no such parameter or group.
std::optional<int> first_parameter(const KinematicChain& chain, const std::string& parameter);

/// Whether the coefficients share one prior deviation: those of a group, and of a whole family.
inline bool is_shrunken(const Effect& effect) {
  return is_group(effect.parameter) || !effect.members.empty();
}

/// The members of a whole family, with their coefficients; otherwise the effect itself.
std::vector<Effect> single_effects(const Effect& effect);

/// What an effect's parameter is measured in; radian of a pose, whose coefficients have units of
/// their own unless the moment turns it.
ParameterUnit unit_of_parameter(const KinematicChain& chain, const std::string& parameter);

/// The reason why no parameter of this name can follow the driver in this shape, with the remedy;
/// empty if it can.
std::string why_invalid(const std::string& parameter, const Driver& driver, const Shape& shape);

}  // namespace armtrue
