#pragma once

#include <array>
#include <string>

#include "armtrue/kinematics/chain.h"
#include "armtrue/text/number_text.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// x_mm, y_mm, z_mm of a map [m]. Throws InputError.
Eigen::Vector3d read_position(YamlMap& map);
/// a_deg, b_deg, c_deg of a map: Rz(a) Ry(b) Rx(c). Throws InputError.
Eigen::Matrix3d read_rotation(YamlMap& map);
/// The numbers of a_deg, b_deg, c_deg.
std::array<NumberText, 3> rotation_texts(const Eigen::Matrix3d& rotation);

/// A pose in mm and degrees: the base or the tool of a robot file. Throws InputError.
Pose read_pose(YamlMap map);
YAML::Node pose_node(const Pose& pose);

/// One entry of the robot file's `links`; read_couplings() reads what it follows. Throws
/// InputError.
Link read_link(YamlMap& map);
/// What the entry of a link of the chain, whose links are known, follows: `follows` of a link
/// without an encoder, `coupled` of one with its own. Adds it to the chain. Throws InputError.
void read_couplings(YamlMap& map, int link, KinematicChain& chain);
YAML::Node link_node(const KinematicChain& chain, int index);

}  // namespace armtrue
