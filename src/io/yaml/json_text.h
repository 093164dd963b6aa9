#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace armtrue {

/// A document as JSON (RFC 8259), with the keys, the order and the digits of its YAML. What stands
/// on one line there stands on one line here.
std::string json_text(const YAML::Node& root);

/// A text of JSON, which begins with {, with each character beyond the first 65,536 as itself: JSON
/// may write it in two halves, such as \ud83e\uddbe, which YAML does not know. Other texts come
/// back as they are.
std::string with_whole_characters(std::string text);

}  // namespace armtrue
