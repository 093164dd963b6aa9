#pragma once

#include <string>

#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// One entry of the robot file's `contacts`. Throws InputError.
Contact read_contact(const std::string& name, YamlMap map);

/// The reverse; a contact without a place has only its kind and its points.
YAML::Node contact_node(const Contact& contact);

/// One entry of `beams`: its origin and direction in the measured frame, or nothing. Throws
/// InputError.
Contact read_beam(const std::string& name, YamlMap map);
YAML::Node beam_node(const Contact& beam);

}  // namespace armtrue
