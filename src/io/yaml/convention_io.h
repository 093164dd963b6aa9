#pragma once

#include "armtrue/effects/robot.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// The entry `links`, from one to kMaxLinks links of different names, and how they follow each
/// other. Throws InputError.
void read_links(YamlMap& map, KinematicChain& chain);

/// Reads the key `convention`: rows of the standard convention become links of the modified one.
/// The chain and the masses are read already. Throws InputError.
void use_convention(YamlMap& document, Robot& robot);

/// Reads the key `positioner` or, of a file that convert-robot or a calibration wrote,
/// `ground_link`: the links of a positioner that carries the part begin the chain. Throws
/// InputError, also for a chain of no or too many joints.
void use_positioner(YamlMap& document, Robot& robot);

}  // namespace armtrue
