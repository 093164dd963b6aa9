#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armtrue/io/provenance.h"

namespace armtrue {

/// A YAML map that is read strictly: a key that was never asked for is an error. Errors throw
/// InputError with file, line and key.
class YamlMap {
 public:
  YamlMap(const YAML::Node& node, std::string file, std::string what);

  bool has(const std::string& key);
  /// Whether there is a key with a value: what is not known stands as null.
  bool has_value(const std::string& key);
  double number(const std::string& key);
  double number(const std::string& key, double otherwise);
  std::string text(const std::string& key);
  std::string text(const std::string& key, const std::string& otherwise);
  /// A text that stands in the rows or headers of tables: in one line.
  std::string name(const std::string& key);
  std::vector<double> numbers(const std::string& key);  ///< a list of any length
  std::vector<double> numbers(const std::string& key, size_t count);
  YamlMap map(const std::string& key);
  std::vector<YamlMap> maps(const std::string& key);       ///< empty if the key is not there
  std::vector<std::string> texts(const std::string& key);  ///< one scalar or a list of them
  std::vector<std::string> keys() const;                   ///< each as name()
  void ignore(const std::string& key) { asked_.insert(key); }

  /// Throws if there is a key that was never asked for.
  void finish() const;

  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  YAML::Node need(const std::string& key);
  std::string instead_of(const std::string& key) const;
  double number_of(const YAML::Node& node, const std::string& key) const;
  void require_one_line(const std::string& name, const YAML::Node& where) const;

  YAML::Node node_;
  std::map<std::string, YAML::Node> values_;
  std::string file_, what_;
  std::set<std::string> asked_;
};

/// Parses a document; its `format:` must be one of `formats`.
YamlMap read_document(const std::string& bytes, const std::string& file,
                      const std::vector<std::string>& formats);

/// The document's `provenance`; what is of another form, as other programs write it, stays empty.
Provenance read_provenance(YamlMap& document);

}  // namespace armtrue
