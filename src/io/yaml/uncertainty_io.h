#pragma once

#include "armtrue/effects/robot.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The robot file's `uncertainty`, its root as a lower triangle, row by row. It is that of the
/// parameters and of the coefficients of all `effects`, or of the first ones: the uncertainty of
/// the others is then not stated. Throws InputError, also if the root has another size, or states
/// nothing for a parameter or more than `deviations`, the robot file's `std`.
Uncertainty read_uncertainty(YamlMap map, const KinematicChain& chain,
                             const std::vector<Effect>& effects,
                             const std::map<std::string, double>& deviations);
YAML::Node uncertainty_node(const Uncertainty& uncertainty);

}  // namespace armtrue
