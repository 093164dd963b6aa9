#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"
#include "armtrue/text/number_text.h"

namespace armtrue {

// A document is built as a tree of nodes, whose keys keep their order, and printed once. A node
// made of a NumberText or by boolean() is a value. Every other scalar, and every key, is a text, and
// is quoted if a reader would take it for something else.

/// true or false.
YAML::Node boolean(bool value);

inline YAML::Node flow(YAML::Node node) {
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// A key and its value.
struct FlowEntry {
  template <typename Value>
  FlowEntry(std::string name, const Value& of_key) : key(std::move(name)), value(of_key) {}
  std::string key;
  YAML::Node value;
};

/// A map on one line.
YAML::Node flow_map(const std::vector<FlowEntry>& entries);
/// A list on one line.
YAML::Node flow_list(const std::vector<double>& values);
/// The same of what `to_node` makes of each value.
template <typename Values, typename ToNode>
YAML::Node flow_list(const Values& values, const ToNode& to_node) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (const auto& value : values) node.push_back(to_node(value));
  return flow(node);
}

/// null for what is unknown or not finite, such as the score of an effect that nothing shows.
YAML::Node rounded_or_null(const std::optional<double>& value);

/// Null for "".
YAML::Node text_or_null(const std::string& text);
/// A list; an empty one stands on the line of its key.
YAML::Node list_node(const std::vector<YAML::Node>& items);
YAML::Node texts_node(const std::vector<std::string>& texts);

/// Name, parameter, driver and shape with its inner values.
YAML::Node effect_form_node(const Effect& effect, const KinematicChain& chain);
YAML::Node effect_node(const Effect& effect, const KinematicChain& chain);
/// SI unit of the parameter that a coefficient moves: m, rad or 1.
std::string si_unit_moved(const Effect& effect, size_t coefficient, const KinematicChain& chain);
/// The unit of a coefficient, such as "rad/(N m)", "m/K" or "1".
std::string coefficient_unit(const Effect& effect, size_t coefficient, const KinematicChain& chain);
/// The base and the zero offsets of each session of a robot.
YAML::Node sessions_node(const Robot& robot);
YAML::Node robot_node(const Robot& robot, const Provenance& provenance);
YAML::Node provenance_node(const Provenance& provenance);

/// Whether a scalar is a number or a truth value, and not a text.
bool is_value(const YAML::Node& scalar);

/// The whole document, as YAML and as JSON. The tags of its nodes are not written.
Document print_document(const YAML::Node& root);

}  // namespace armtrue

template <>
struct YAML::convert<armtrue::NumberText> {
  static Node encode(const armtrue::NumberText& number);
};
