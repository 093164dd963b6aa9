#pragma once

#include <map>
#include <string>
#include <utility>

namespace armtrue {

/// A product of keys and values. The string is its YAML text. json() has the same keys in the same
/// order, with the same digits.
class Document : public std::string {
 public:
  Document() = default;
  Document(std::string yaml, std::string json, std::map<std::string, std::string> values)
      : std::string(std::move(yaml)), json_(std::move(json)), values_(std::move(values)) {}

  const std::string& json() const { return json_; }

  /// The value at a path of keys and places in lists, such as `stages/0/name`; null if there is
  /// none.
  const std::string* value(const std::string& path) const {
    const auto found = values_.find(path);
    return found == values_.end() ? nullptr : &found->second;
  }

 private:
  std::string json_;
  std::map<std::string, std::string> values_;
};

/// Whether a document is written to this file as JSON: its name ends in .json.
bool is_json_file(const std::string& path);

}  // namespace armtrue
