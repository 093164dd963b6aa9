#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// One entry of `cameras` or `boards`. Throws InputError.
Contact read_camera(const std::string& name, YamlMap map);
Contact read_board(const std::string& name, YamlMap map);

YAML::Node node_of_images(const Contact& contact);

}  // namespace armtrue
