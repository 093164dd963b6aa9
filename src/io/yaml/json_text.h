#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace armtrue {

/// A document as JSON (RFC 8259), with the keys, the order and the digits of its YAML. What stands
/// on one line there stands on one line here.
std::string json_text(const YAML::Node& root);

/// A text in quotes.
std::string json_quoted(const std::string& text);

/// A text of JSON, which begins with { or [, with surrogate pairs such as \ud83e\uddbe replaced by
/// their characters: YAML does not know such pairs. Other texts come back unchanged.
std::string with_whole_characters(std::string text);

}  // namespace armtrue
