#pragma once

#include <string>
#include <utility>

namespace armtrue {

/// A product of keys and values. It is its own YAML text; json() says the same, key by key in the
/// same order and number by number, for readers of JSON.
class Document : public std::string {
 public:
  Document() = default;
  Document(std::string yaml, std::string json)
      : std::string(std::move(yaml)), json_(std::move(json)) {}

  const std::string& json() const { return json_; }

 private:
  std::string json_;
};

/// Whether a document goes into this file as JSON: its name ends in .json.
bool is_json_file(const std::string& path);

}  // namespace armtrue
