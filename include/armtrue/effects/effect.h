#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/driver.h"
#include "armtrue/effects/shape.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// One identified number of an effect, in SI: unit of the parameter / unit of shape(driver).
struct Coefficient {
  std::string name;  ///< "c"; "sin", "cos"; "rx", ...
  double value = 0;
  double std = 0;  ///< 0 if it was not identified here
  /// 95 % interval; takes the masses of the robot file as exact.
  std::array<double, 2> ci95{0, 0};
};

/// One cause that acts on many parameters, such as gravity on the compliance of every joint. Each
/// coefficient of a member has the prior N(0, (f t)^2), with t the typical size of the member and f
/// a factor that is common to the family. The readings determine f.
struct Family {
  std::string name;
  double typical = 0;  ///< typical size of each coefficient of this effect, in its unit
};

/// A parameter that is not constant:
///     parameter(context) = constant + f * sum_k c_k shape_k(driver(context)),
/// with f the factor of the driver, 1 if it has none.
///
/// `parameter` names one parameter, or one of these groups:
///     base, tool        x y z rx ry rz
///     target <name>     x y z, its position
///     instrument.point  x y z, an error of all points that the instrument reads
/// Each parameter of a group has its own coefficients. `arm.scale` has one for all lengths, each of
/// which becomes (1 + effect) times as long. With the driver `force` each parameter follows the
/// generalised force on itself. With the driver `moment` the effect turns the group: its rotation
/// vector is one common coefficient times the vector of the moment.
struct Effect {
  std::string name;
  Parameter parameter;
  Driver driver;
  Shape shape;
  std::vector<Coefficient> coefficients;
  std::optional<Family> family{};  ///< to which the effect belongs
  /// Whether the effect may be an error of the instrument and not of the arm; see
  /// may_be_instrument(). The effect then predicts readings, but does not correct programs.
  bool may_be_instrument = false;
  /// If may_be_instrument, or if a scale of the instrument may be the growth of the arm: mean of
  /// the effect over the poses of its calibration [SI]. Programs are then corrected with
  /// constant + mean, see without_station_effects().
  double mean = 0;
  /// If it can be bounded: the lowest and highest value of the driver in its calibration [SI].
  /// Beyond this range the effect keeps its value at the nearer end: it does not extrapolate.
  std::optional<std::array<double, 2>> driver_range{};
  /// Not empty if this is a whole family: its effects. `coefficients` then holds theirs, one after
  /// the other, and `parameter` names the family. Occurs only during a search.
  std::vector<Effect> members{};
};

/// Name of the many small effects that together predict what the named ones leave. None of them is
/// a finding.
inline constexpr const char* kRemainder = "part of the remainder";

/// Whether both have the same parameter and the same driver.
inline bool same_place(const Effect& a, const Effect& b) {
  return a.parameter == b.parameter && a.driver == b.driver;
}

/// Whether both have the same parameter, driver and shape; coefficients may differ.
inline bool same_form(const Effect& a, const Effect& b) {
  return same_place(a, b) && a.shape == b.shape;
}

/// Whether the effect is a function of one joint angle alone.
inline bool is_of_one_angle(const Effect& effect) {
  const Driver& driver = effect.driver;
  return driver.kind == DriverKind::joint_angle && !driver.is_pair() && !driver.factor;
}

/// Whether `driver_range` can bound the effect: a function of one joint angle, of the time or of
/// one temperature alone.
inline bool can_be_bounded(const Effect& effect) {
  const Driver& driver = effect.driver;
  return is_of_one_angle(effect) ||
         (!driver.is_pair() && !driver.factor &&
          (driver.kind == DriverKind::time || driver.kind == DriverKind::temperature));
}

/// Whether an effect is a lasting error of the instrument: on a parameter of the instrument, driven
/// by neither time nor session. An effect on its scale does not count: the lengths of the arm
/// imitate it.
bool is_lasting_of_instrument(const Effect& effect);

/// Number of parameters in the group `parameter`: 6 for a pose, 3 for a point, 1 if it is no group.
int group_size(const Parameter& parameter);
inline bool is_group(const Parameter& parameter) { return group_size(parameter) > 1; }

/// Index of the first parameter of the group; nothing if the chain has no such parameter or group.
std::optional<int> first_parameter(const KinematicChain& chain, const Parameter& parameter);

/// The owner of the parameter; of a whole family the owner of all its members, or `several`.
Owner owner_of(const Effect& effect);

/// Whether parameters of this owner change readings and move no part of the arm.
bool moves_reading_alone(Owner owner);

/// Whether the coefficients share one prior standard deviation: those of a group or a whole family.
inline bool is_shrunken(const Effect& effect) {
  return is_group(effect.parameter) || !effect.members.empty();
}

/// The members of a whole family with their coefficients; for any other effect, the effect itself.
std::vector<Effect> single_effects(const Effect& effect);

/// Of a step driven by `session`: the first session after it. Throws std::out_of_range if there is
/// none.
const std::string& first_session_after(const Effect& effect);

/// Unit of the parameter of an effect. Of a pose it is radian, which is right if the driver
/// `moment` turns it; other effects on a pose move it in m and rad.
ParameterUnit unit_of_parameter(const KinematicChain& chain, const Parameter& parameter);
/// The unit in which products show it.
DisplayUnit display_unit(const KinematicChain& chain, const Parameter& parameter);

/// If the parameter cannot follow the driver in this shape: the reason and the remedy. Otherwise
/// empty.
std::string why_invalid(const Parameter& parameter, const Driver& driver, const Shape& shape);

}  // namespace armtrue
