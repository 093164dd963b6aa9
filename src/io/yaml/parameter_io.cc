#include "io/yaml/parameter_io.h"

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/text/number_text.h"

namespace armtrue {

int constant_parameter(const YamlMap& map, const std::string& key, const std::string& name,
                       const KinematicChain& chain) {
  const auto parameter = find_parameter(chain, name);
  if (!parameter) map.fail(key, "the robot has no parameter '" + name + "'");
  if (*parameter == layout_of(chain).arm_scale)
    map.fail(key, name +
                      " is all lengths at once, of which only an effect changes the scale; name "
                      "lengths, such as A2.d");
  if (layout_of(chain).is_of_instrument(*parameter))
    map.fail(key, name +
                      " is not identified with the robot; remove it, and let an effect fit it: "
                      "{name: instrument, parameter: " +
                      name +
                      ", driver: position, shape: linear, coefficients: [{name: c, value: 0}]}");
  return *parameter;
}

bool is_zero_offset(const KinematicChain& chain, const std::string& name) {
  const auto parameter = find_parameter(chain, name);
  return parameter && armtrue::is_zero_offset(chain, *parameter);
}

namespace {

double file_unit(const KinematicChain& chain, int parameter) {
  if (const ParameterLayout layout = layout_of(chain); layout.is_of_couplings(parameter))
    return coefficient_unit(chain, chain.couplings[parameter - layout.couplings]);
  switch (parameter_unit(chain, parameter)) {
    case ParameterUnit::metre:
      return kMillimetre;
    case ParameterUnit::radian:
      return kDegree;
    case ParameterUnit::one:
    case ParameterUnit::pixel:
      break;
  }
  return 1;
}

}  // namespace

std::map<std::string, double> read_deviations(YamlMap map, const KinematicChain& chain) {
  std::map<std::string, double> deviations;
  for (const std::string& key : map.keys()) {
    const int parameter = constant_parameter(map, key, key, chain);
    const double value = map.number(key);
    if (value <= 0) map.fail(key, "a standard deviation must be above zero");
    deviations[key] = value * file_unit(chain, parameter);
  }
  return deviations;
}

namespace {

template <typename Text>
YAML::Node deviations_node(const std::map<std::string, double>& values, const KinematicChain& chain,
                           const Text& text) {
  YAML::Node node;
  for (int k = 0; k < parameter_count(chain); ++k) {
    const std::string name = parameter_name(chain, k);
    const auto found = values.find(name);
    if (found != values.end() && std::isfinite(found->second))  // else nothing shows it
      node[name] = text(found->second, file_unit(chain, k));
  }
  return node;
}

}  // namespace

YAML::Node std_node(const std::map<std::string, double>& values, const KinematicChain& chain) {
  return deviations_node(values, chain,
                         [](double si, double unit) { return rounded(si / unit); });
}

YAML::Node priors_node(const std::map<std::string, double>& values, const KinematicChain& chain) {
  return deviations_node(values, chain,
                         [](double si, double unit) { return number_text(si, unit); });
}

}  // namespace armtrue
