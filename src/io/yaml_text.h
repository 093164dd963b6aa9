#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <utility>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/io/provenance.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/text/number_text.h"

namespace armtrue {

// Documents are built as trees of nodes, whose keys keep their order, and printed once. Numbers are
// put in as text, so that they read back exactly.

inline YAML::Node flow(YAML::Node node) {
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// A map on one line.
YAML::Node flow_map(const std::vector<std::pair<std::string, std::string>>& entries);
/// A list on one line.
YAML::Node flow_list(const std::vector<double>& values);

/// Four significant digits, which are all that a statistic carries.
std::string rounded(double value);

YAML::Node error_node(const ErrorSummary& errors, double unit);

/// Name, parameter, driver and shape with its inner values.
YAML::Node effect_form_node(const Effect& effect);
YAML::Node effect_node(const Effect& effect, const KinematicChain& chain);
/// What each session of a robot has for itself.
YAML::Node sessions_node(const Robot& robot);
YAML::Node robot_node(const Robot& robot, const Provenance& provenance);
YAML::Node provenance_node(const Provenance& provenance);

std::string print_document(const YAML::Node& root);

}  // namespace armtrue
