#pragma once

#include <vector>

#include "armtrue/calibration/gross_poses.h"
#include "armtrue/kinematics/units.h"
#include "io/yaml/yaml_text.h"

namespace armtrue {

/// A list of {pose, off_mm, likely}.
inline YAML::Node gross_poses_node(const std::vector<GrossPose>& gross) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const GrossPose& pose : gross) {
    YAML::Node node;
    node["pose"] = pose.id;
    node["off_mm"] = rounded(pose.off / kMillimetre);
    node["likely"] = pose.likely;
    list.push_back(node);
  }
  return list;
}

}  // namespace armtrue
