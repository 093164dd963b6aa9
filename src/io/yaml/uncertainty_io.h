#pragma once

#include "armtrue/effects/robot.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The robot file's `uncertainty`, its root as a lower triangle, row by row. Throws InputError.
Uncertainty read_uncertainty(YamlMap map, const KinematicChain& chain);
YAML::Node uncertainty_node(const Uncertainty& uncertainty);

}  // namespace armtrue
