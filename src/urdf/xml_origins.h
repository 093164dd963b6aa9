#pragma once

#include <map>
#include <string>

#include "armtrue/kinematics/pose.h"

namespace armtrue {

/// The document with other origins for some joints, by name: only the numbers of `xyz` and `rpy`
/// change; what is missing is added. The document has been parsed as a URDF before. Throws
/// InputError unless the document has exactly one joint of each name.
std::string with_origins(const std::string& document, const std::map<std::string, Pose>& origins,
                         const std::string& file);

}  // namespace armtrue
