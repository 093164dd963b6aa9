#include "armtrue/effects/effect.h"

namespace armtrue {

int group_size(const std::string& parameter) {
  if (parameter == "base" || parameter == "tool") return 6;
  if (parameter == kPointOfInstrument) return 3;
  return parameter.starts_with("target ") && parameter.find('.') == std::string::npos ? 3 : 1;
}

std::optional<int> first_parameter(const KinematicChain& chain, const std::string& parameter) {
  // A shift of all measured points is the same as a shift of the base.
  if (parameter == kPointOfInstrument) return kFirstBaseParameter;
  return find_parameter(chain, is_group(parameter) ? parameter + ".x" : parameter);
}

ParameterUnit unit_of_parameter(const KinematicChain& chain, const std::string& parameter) {
  if (group_size(parameter) == 6) return ParameterUnit::radian;
  const auto index = first_parameter(chain, parameter);
  return index ? parameter_unit(chain, *index) : ParameterUnit::radian;
}

DisplayUnit display_unit(const KinematicChain& chain, const std::string& parameter) {
  return display_unit(unit_of_parameter(chain, parameter));
}

std::string why_invalid(const std::string& parameter, const Driver& driver, const Shape& shape) {
  const bool of_instrument = parameter.starts_with("instrument.");
  const bool moves_reading = of_instrument || parameter.starts_with("target ") ||
                             parameter.starts_with("anchor ") || parameter.starts_with("contact ");
  if (driver.is_pair() && shape.kind != ShapeKind::series)
    return "two joint angles need the shape 'series'";
  if ((driver.kind == DriverKind::place) != is_polynomial(shape))
    return "'place' drives the shape 'series' in the basis 'polynomial', and it alone drives that";
  if (driver.kind == DriverKind::position &&
      (!of_instrument || parameter == "instrument.azimuth" || parameter == kPointOfInstrument))
    return "'position', the reading itself, drives instrument.scale, .range and .elevation alone, "
           "and would be a constant of '" +
           parameter + "'; name what changes it from reading to reading";
  if (moves_reading && (driver.kind == DriverKind::moment || driver.involves(DriverKind::force)))
    return "'moment' and 'force' are what a load does on the parameter itself, and on " +
           parameter + ", which moves no part of the arm, it does none; take another driver";
  if (shape.kind == ShapeKind::pre_sliding && driver.kind != DriverKind::stroke)
    return "the shape 'pre-sliding' needs the driver 'stroke <j>', the way since the last reversal";
  if (has_at(shape.kind) && driver.kind != DriverKind::time && !is_angle(driver.kind))
    return "the shape '" + to_string(shape) + "' needs a time or an angle as driver";
  return "";
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
