#include "armtrue/effects/effect.h"

namespace armtrue {

ParameterUnit unit_of_parameter(const KinematicChain& chain, const std::string& parameter) {
  const auto index = find_parameter(chain, parameter);
  return index ? parameter_unit(*index) : ParameterUnit::radian;
}

std::string why_invalid(const std::string& parameter, const Driver& driver, const Shape& shape) {
  if (driver.is_pair() && shape.kind != ShapeKind::series)
    return "two joint angles need the shape 'series'";
  const bool is_scale = parameter == "instrument.scale";
  if (driver.kind == DriverKind::position && !is_scale)
    return "'position', the reading itself, drives instrument.scale alone, and would be a constant "
           "of '" +
           parameter + "'; name what changes it from reading to reading";
  if (is_scale && (driver.kind == DriverKind::moment || driver.involves(DriverKind::force)))
    return "'moment' and 'force' are what a load does on the parameter itself, and on "
           "instrument.scale, which moves nothing, it does none; take another driver";
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
