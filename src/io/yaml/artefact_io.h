#pragma once

#include <yaml-cpp/yaml.h>

#include "armtrue/kinematics/chain.h"
#include "io/yaml/yaml_map.h"

namespace armtrue {

/// Whether a word of `kind` names an artefact, or one of the short forms of some: cube, step-gauge.
bool is_artefact_word(const std::string& word);

/// What stands in the entry of an artefact beside its place: `points`, `faces`, `balls`,
/// `tip_radius_mm` and `radius_mm`, or the sizes of a short form. Throws InputError.
void read_artefact(YamlMap& map, const std::string& word, Contact& artefact);

/// The reverse, in the long form, added to the node of the contact.
void add_artefact(const Contact& artefact, YAML::Node node);

}  // namespace armtrue
