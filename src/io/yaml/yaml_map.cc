#include "io/yaml/yaml_map.h"

#include <algorithm>
#include <cmath>

#include "armtrue/io/source.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/utf8.h"
#include "io/yaml/json_text.h"
#include "io/yaml/yaml_bounds.h"

namespace armtrue {

YamlMap::YamlMap(const YAML::Node& node, std::string file, std::string what)
    : node_(node), file_(std::move(file)), what_(std::move(what)) {
  if (!node_.IsMap())
    throw InputError(file_ + ":" + std::to_string(node_.Mark().line + 1) + ": " + what_ +
                     " must be a map of keys");
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar())
      throw InputError(file_ + ":" + std::to_string(entry.first.Mark().line + 1) + ": a key of " +
                       what_ + " is no text; write 'key: value'");
    const auto key = entry.first.as<std::string>();
    if (!values_.emplace(key, entry.second).second)
      throw InputError(file_ + ":" + std::to_string(entry.first.Mark().line + 1) + ": key '" + key +
                       "' stands twice in " + what_ + "; remove one");
  }
}

void YamlMap::fail(const std::string& key, const std::string& why) const {
  const auto found = values_.find(key);
  int line = (found == values_.end() ? node_ : found->second).Mark().line;
  if (found != values_.end() &&
      found->second.IsNull())  // an empty value stands where the next begins
    for (const auto& entry : node_)
      if (entry.first.Scalar() == key) line = entry.first.Mark().line;
  throw InputError(file_ + ":" + std::to_string(line + 1) + ": key '" + key + "' of " + what_ +
                   ": " + why);
}

// d_m where d_mm is missing, max_deg where a prismatic joint needs max_mm.
std::string YamlMap::instead_of(const std::string& key) const {
  const size_t unit = key.rfind('_');
  if (unit == std::string::npos) return "";
  const auto found = std::ranges::find_if(values_, [&](const auto& entry) {
    return entry.first.rfind('_') == unit && entry.first.starts_with(key.substr(0, unit + 1));
  });
  return found == values_.end() ? "" : "; '" + found->first + "' stands in its place";
}

bool YamlMap::has(const std::string& key) {
  asked_.insert(key);
  return values_.contains(key);
}

bool YamlMap::has_value(const std::string& key) { return has(key) && !values_.at(key).IsNull(); }

YAML::Node YamlMap::need(const std::string& key) {
  if (!has(key)) fail(key, "is missing" + instead_of(key));
  return values_.at(key);
}

double YamlMap::number_of(const YAML::Node& node, const std::string& key) const {
  if (node.IsNull()) fail(key, "is empty; fill in a number");
  if (!node.IsScalar()) fail(key, "must be a number");
  const std::string& text = node.Scalar();
  const std::optional<double> read = read_number(text);
  if (!read || !std::isfinite(*read)) fail(key, "'" + text + "' is no finite number");
  const double value = *read;
  if (std::abs(value) > kMaxNumber) fail(key, "'" + text + "' is larger than anything real");
  return value;
}

double YamlMap::number(const std::string& key) { return number_of(need(key), key); }

double YamlMap::number(const std::string& key, double otherwise) {
  return has(key) ? number(key) : otherwise;
}

std::string YamlMap::text(const std::string& key) {
  const YAML::Node node = need(key);
  if (node.IsNull()) fail(key, "is empty; fill in a text");
  if (!node.IsScalar()) fail(key, "must be a text");
  return node.Scalar();
}

std::string YamlMap::text(const std::string& key, const std::string& otherwise) {
  return has(key) ? text(key) : otherwise;
}

std::vector<double> YamlMap::numbers(const std::string& key) {
  const YAML::Node node = need(key);
  if (!node.IsSequence()) fail(key, "must be a list of numbers");
  std::vector<double> values;
  for (const auto& item : node) values.push_back(number_of(item, key));
  return values;
}

std::vector<double> YamlMap::numbers(const std::string& key, size_t count) {
  const YAML::Node node = need(key);
  if (!node.IsSequence() || node.size() != count)
    fail(key, "must be a list of " + std::to_string(count) + " numbers");
  return numbers(key);
}

YamlMap YamlMap::map(const std::string& key) { return {need(key), file_, "'" + key + "'"}; }

std::vector<YamlMap> YamlMap::maps(const std::string& key) {
  std::vector<YamlMap> items;
  if (!has_value(key)) return items;
  const YAML::Node& node = values_.at(key);
  if (!node.IsSequence()) fail(key, "must be a list");
  for (const auto& item : node) items.emplace_back(item, file_, "an entry of '" + key + "'");
  return items;
}

std::vector<std::string> YamlMap::texts(const std::string& key) {
  const YAML::Node node = need(key);
  if (node.IsScalar()) return {node.Scalar()};
  if (!node.IsSequence()) fail(key, "must be a text or a list of texts");
  std::vector<std::string> items;
  for (const auto& item : node) {
    if (!item.IsScalar()) fail(key, "must be a list of texts");
    items.push_back(item.Scalar());
  }
  return items;
}

void YamlMap::require_one_line(const std::string& name, const YAML::Node& where) const {
  const auto is_control = [](char c) { return c != '\t' && c >= 0 && c < ' '; };
  if (std::ranges::none_of(name, is_control)) return;
  std::string shown = name;
  std::ranges::replace_if(shown, is_control, ' ');
  throw InputError(file_ + ":" + std::to_string(where.Mark().line + 1) + ": the name '" + shown +
                   "' in " + what_ +
                   " holds a line feed or another control character, which no row of a table can "
                   "hold; write the name in one line");
}

std::string YamlMap::name(const std::string& key) {
  const std::string name = text(key);
  require_one_line(name, values_.at(key));
  return name;
}

std::vector<std::string> YamlMap::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : node_) {
    names.push_back(entry.first.as<std::string>());
    require_one_line(names.back(), entry.first);
  }
  return names;
}

void YamlMap::finish() const {
  for (const auto& entry : node_) {
    const auto key = entry.first.as<std::string>();
    if (!asked_.contains(key))
      throw InputError(file_ + ":" + std::to_string(entry.first.Mark().line + 1) + ": key '" + key +
                       "' is not known in " + what_ +
                       (read_number(key)
                            ? "; is it the end of a number with a comma? Write 500.0, not 500,0"
                            : "; correct or remove it"));
  }
}

YamlMap read_document(const std::string& bytes, const std::string& file,
                      const std::vector<std::string>& formats) {
  std::string expected = "expected 'format: " + formats.front();
  for (size_t k = 1; k < formats.size(); ++k) expected += " or " + formats[k];
  expected += "'";
  check_text(bytes, file);
  const std::string text = with_whole_characters(as_utf8(bytes));
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '<')
    throw InputError(file + ":1: is XML, and a YAML document should stand here; " + expected +
                     ". convert-robot --to yaml makes a robot file of a URDF");
  check_yaml_bounds(text, file);
  const std::vector<YAML::Node> documents = YAML::LoadAll(text);
  const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
  for (size_t k = 1; k < documents.size(); ++k)
    if (!documents[k].IsNull())
      throw InputError(file + ":" + std::to_string(documents[k].Mark().line + 1) +
                       ": a second document stands here, after '---'; give it a file of its own");
  if (!root || root.IsNull()) throw InputError(file + ": is empty; " + expected);
  if (root.IsScalar() || root.IsSequence())
    throw InputError(file + ":1: is no YAML document but a table or other text; " + expected +
                     (text.find(',') < text.find('\n')
                          ? ". Are this file and that of the readings exchanged?"
                          : ""));
  YamlMap document(root, file, "the document");
  const std::string format = document.text("format", "");
  if (std::find(formats.begin(), formats.end(), format) == formats.end()) {
    const bool lacks_robot = format == "armtrue-loop/1" && formats.front() == "armtrue-robot/1";
    document.fail("format", expected + (format.empty() ? "" : "; it is '" + format + "'") +
                                (lacks_robot ? ". close-loop --robot-out writes the robot" : ""));
  }
  return document;
}

}  // namespace armtrue
