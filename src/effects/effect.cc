#include "armtrue/effects/effect.h"

#include <algorithm>
#include <cmath>

#include "armtrue/effects/gravity_basis.h"

namespace armtrue {

bool is_lasting_of_instrument(const Effect& effect) {
  return owner_of(effect) == Owner::instrument &&
         !is_instrument_parameter(effect.parameter, InstrumentParameter::scale) &&
         !effect.driver.follows_course();
}

int group_size(const Parameter& parameter) {
  if (parameter.component != Parameter::kWhole) return 1;
  switch (parameter.owner) {
    case Owner::base:
    case Owner::tool:
      return kParametersPerPose;
    case Owner::instrument:
    case Owner::target:
      return 3;
    case Owner::arm:
    case Owner::link:
    case Owner::coupling:
    case Owner::anchor:
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact:
    case Owner::several:
      break;
  }
  return 1;
}

bool has_gravity_basis(const Effect& effect) {
  const DriverKind driver = effect.driver.kind;
  if (effect.shape.kind != ShapeKind::linear) return false;
  const auto coefficients = std::ssize(effect.coefficients);
  if (driver == DriverKind::moment) return coefficients > 1;  // of a group the vector has one
  return driver == DriverKind::gravity_torque && coefficients > group_size(effect.parameter);
}

std::optional<int> first_parameter(const KinematicChain& chain, const Parameter& parameter) {
  if (!is_group(parameter)) return find_parameter(chain, parameter);
  // A shift of all measured points is the same as a shift of the base.
  if (parameter.owner == Owner::instrument) return kFirstBaseParameter;
  return find_parameter(chain, {parameter.owner, parameter.of, 0});
}

Owner owner_of(const Effect& effect) {
  if (effect.members.empty()) return effect.parameter.owner;
  const Owner owner = owner_of(effect.members.front());
  const bool is_of_one = std::ranges::all_of(
      effect.members, [&](const Effect& member) { return owner_of(member) == owner; });
  return is_of_one ? owner : Owner::several;
}

ParameterUnit unit_of_parameter(const KinematicChain& chain, const Parameter& parameter) {
  if (group_size(parameter) == 6) return ParameterUnit::radian;
  const auto index = first_parameter(chain, parameter);
  return index ? parameter_unit(chain, *index) : ParameterUnit::radian;
}

DisplayUnit display_unit(const KinematicChain& chain, const Parameter& parameter) {
  return display_unit(unit_of_parameter(chain, parameter));
}

bool moves_reading_alone(Owner owner) {
  switch (owner) {
    case Owner::instrument:
    case Owner::target:
    case Owner::anchor:
    case Owner::beam:
    case Owner::board:
    case Owner::camera:
    case Owner::contact:
      return true;
    case Owner::arm:
    case Owner::link:
    case Owner::coupling:
    case Owner::base:
    case Owner::tool:
    case Owner::several:
      break;
  }
  return false;
}

std::string why_invalid(const Parameter& parameter, const Driver& driver, const Shape& shape) {
  const bool of_instrument = parameter.owner == Owner::instrument;
  if (driver.is_pair() && shape.kind != ShapeKind::series)
    return "two joint angles need the shape 'series'";
  if ((driver.kind == DriverKind::place) != is_polynomial(shape))
    return "'place' drives the shape 'series' in the basis 'polynomial', and it alone drives that";
  if (driver.kind == DriverKind::constant &&
      (!of_instrument || is_group(parameter) ||
       is_instrument_parameter(parameter, InstrumentParameter::azimuth)))
    return "'position', the reading itself, drives instrument.scale, .range and .elevation alone, "
           "and would be a constant of '" +
           to_string(parameter) + "'; name what changes it from reading to reading";
  const bool by_load = driver.kind == DriverKind::moment || driver.involves(DriverKind::force);
  if (by_load && is_arm_scale(parameter))
    return "'moment' and 'force' act on one parameter, and arm.scale is many lengths; take one of "
           "them";
  if (by_load && moves_reading_alone(parameter.owner))
    return "'moment' and 'force' are what a load does on the parameter itself, and on " +
           to_string(parameter) + ", which moves no part of the arm, it does none; take another driver";
  if (shape.kind == ShapeKind::pre_sliding && driver.kind != DriverKind::stroke)
    return "the shape 'pre-sliding' needs the driver 'stroke <j>', the way since the last reversal";
  if (driver.kind == DriverKind::gravity_direction &&
      (parameter.owner != Owner::tool || driver.factor ||
       (shape.kind != ShapeKind::linear && shape.kind != ShapeKind::sign)))
    return "'gravity-direction', a vector in the axes of the last link, drives the tool or a "
           "parameter of it in the shape 'linear' or 'sign', without a factor";
  if (driver.involves(DriverKind::session) &&
      (driver.kind != DriverKind::session || shape.kind != ShapeKind::step))
    return "'session' says since when something stands otherwise: it drives the shape 'step'";
  if (has_at(shape.kind) && !driver.follows_course() && !is_angle_or_travel(driver.kind))
    return "the shape '" + to_string(shape) + "' needs a time or an angle as driver";
  return "";
}

const std::string& first_session_after(const Effect& effect) {
  return effect.driver.sessions.at(static_cast<size_t>(std::ceil(effect.shape.at)));
}

std::vector<Effect> single_effects(const Effect& effect) {
  if (effect.members.empty()) return {effect};
  std::vector<Effect> singles = effect.members;
  auto next = effect.coefficients.begin();
  for (Effect& single : singles)
    for (Coefficient& c : single.coefficients) {
      const std::string name = c.name;
      c = *next++;
      c.name = name;
    }
  return singles;
}

}  // namespace armtrue
