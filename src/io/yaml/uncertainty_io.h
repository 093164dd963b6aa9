#pragma once

#include "armtrue/effects/robot.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The robot file's `uncertainty`, its root as a lower triangle, row by row; `coefficients`: number
/// of those of all effects of the robot. Throws InputError, also if the root has another size.
Uncertainty read_uncertainty(YamlMap map, const KinematicChain& chain, size_t coefficients);
YAML::Node uncertainty_node(const Uncertainty& uncertainty);

}  // namespace armtrue
