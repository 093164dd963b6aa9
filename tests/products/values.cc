// Prints what armtrue's own readers see in products, as JSON, one line for each file:
//
//   product_values FILE...
//
// A document, YAML or JSON: maps as lists of [key, value], lists, null, and scalars as {"text":
// ..., "is_text": whether it is quoted}. A CSV table: {"rows": [[cell, ...], ...]}, the header
// first.

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "armtrue/io/source.h"
#include "io/csv_table.h"

namespace {

std::string quoted(std::string_view text) {
  std::string json = "\"";
  for (const char c : text)
    if (c == '"' || c == '\\')
      (json += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20)
      json += fmt::format("\\u{:04x}", static_cast<int>(c));
    else
      json += c;
  return json + '"';
}

std::string scalar(const YAML::Node& node) {
  return fmt::format("{{\"text\": {}, \"is_text\": {}}}", quoted(node.Scalar()), node.Tag() == "!");
}

std::string json_of(const YAML::Node& node) {
  std::string json;
  const auto add = [&](const std::string& item) { json += (json.empty() ? "" : ", ") + item; };
  if (node.IsMap()) {
    for (const auto& entry : node)
      add("[" + scalar(entry.first) + ", " + json_of(entry.second) + "]");
    return "{\"map\": [" + json + "]}";
  }
  if (node.IsSequence()) {
    for (const auto& item : node) add(json_of(item));
    return "[" + json + "]";
  }
  return node.IsScalar() ? scalar(node) : "null";
}

std::string json_of_table(const std::string& file) {
  armtrue::Source source(file);
  armtrue::CsvTable table(source, "pose");
  const auto columns = static_cast<int>(table.columns().size());
  std::string rows;
  const auto add = [&](const auto& cell) {
    std::string row;
    for (int c = 0; c < columns; ++c) row += (c ? ", " : "") + quoted(cell(c));
    rows += (rows.empty() ? "[" : ", [") + row + "]";
  };
  add([&](int c) { return table.columns()[static_cast<size_t>(c)]; });
  while (table.next_row()) add([&](int c) { return std::string(table.original(c)); });
  return "{\"rows\": [" + rows + "]}";
}

}  // namespace

int main(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string file = argv[k];
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    const bool is_yaml = text.str().starts_with("format: ") || text.str().starts_with('{');
    std::cout << (is_yaml ? json_of(YAML::Load(text.str())) : json_of_table(file)) << "\n";
  }
}
