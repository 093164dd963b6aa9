#pragma once

#include <map>
#include <string>

#include "armtrue/kinematics/parameters.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// Index of a parameter that is constant. Those of the instrument are not: only effects have them.
/// Throws InputError at `key`.
int constant_parameter(const YamlMap& map, const std::string& key, const std::string& name,
                       const KinematicChain& chain);

/// Whether the robot has this parameter, and it is a zero offset.
bool is_zero_offset(const KinematicChain& chain, const std::string& name);

/// Standard deviations [SI] by the names of the parameters: of priors, or of a calibration. Throws
/// InputError.
std::map<std::string, double> read_deviations(YamlMap map, const KinematicChain& chain);
/// With four digits: a standard deviation is not known better.
YAML::Node std_node(const std::map<std::string, double>& values, const KinematicChain& chain);
/// With all digits, as a user gave them.
YAML::Node priors_node(const std::map<std::string, double>& values, const KinematicChain& chain);

}  // namespace armtrue
