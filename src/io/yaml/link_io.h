#pragma once

#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// A pose in mm and degrees: the base or the tool of a robot file. Throws InputError.
Pose read_pose(YamlMap map);
YAML::Node pose_node(const Pose& pose);

/// One entry of the robot file's `links`. Throws InputError.
Link read_link(YamlMap map);
YAML::Node link_node(const Link& link);

}  // namespace armtrue
