#include "io/table_json.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "armtrue/io/source.h"
#include "armtrue/text/input_error.h"
#include "io/csv_cell.h"
#include "io/csv_table.h"
#include "io/yaml/json_text.h"

namespace armtrue {
namespace {

// Columns of names, which may look like numbers.
constexpr std::string_view kNameColumns[] = {
    "pose",    "target", "anchor",    "session", "camera",  "board",     "corner", "beam",
    "contact", "split",  "parameter", "unit",    "program", "why",       "axis",   "field",
    "name",    "note",   "notes",     "file",    "image",   "target_id", "group"};

// A number of JSON: -0.5, 12, 1.5e-05, but not 007, .5 or +1.
bool is_json_number(std::string_view text) {
  const auto take_digits = [&text] {
    const size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(count);
    return count;
  };
  const auto take = [&text](std::string_view one_of) {
    const bool is_there = !text.empty() && one_of.find(text[0]) != one_of.npos;
    if (is_there) text.remove_prefix(1);
    return is_there;
  };
  take("-");
  if (!take("0") && take_digits() == 0) return false;
  if (take(".") && take_digits() == 0) return false;
  if (take("eE")) {
    take("+-");
    if (take_digits() == 0) return false;
  }
  return text.empty();
}

std::string json_cell(std::string_view cell, bool is_name) {
  if (cell.empty()) return "null";
  if (!is_name && is_json_number(cell)) return std::string(cell);
  return json_quoted(std::string(cell));
}

// Columns in the order in which rows have them first.
std::vector<std::string> columns_of(const YAML::Node& rows, const std::string& name) {
  std::vector<std::string> columns;
  int entry = 0;
  for (const YAML::Node& row : rows) {
    ++entry;
    if (!row.IsMap())
      throw InputError(
          fmt::format("{}: entry {} of the list is no row such as "
                      "{{\"pose\": \"1\", \"q1_deg\": 10}}",
                      name, entry));
    for (const auto& cell : row)
      if (std::ranges::find(columns, cell.first.Scalar()) == columns.end())
        columns.push_back(cell.first.Scalar());
  }
  if (columns.empty()) throw InputError(name + ": is an empty list; a table needs a row");
  return columns;
}

std::string text_of_cell(const YAML::Node& cell, const std::string& column,
                         const std::string& name) {
  if (!cell.IsDefined() || cell.IsNull()) return "";
  if (!cell.IsScalar() || cell.Scalar().find_first_of("\r\n") != std::string::npos)
    throw InputError(
        fmt::format("{}: '{}' holds no single value; a cell of a table is a number, a "
                    "text of one line or null",
                    name, column));
  return csv_cell(cell.Scalar());
}

}  // namespace

std::string table_as_json(const std::string& csv) {
  Source source("", csv, 0);
  CsvTable table(source, "");
  std::vector<std::string> keys;
  std::vector<bool> is_name;
  for (const std::string& column : table.columns()) {
    keys.push_back(json_quoted(column) + ": ");
    is_name.push_back(std::ranges::find(kNameColumns, column) != std::end(kNameColumns));
  }
  std::string json = "[";
  const char* before = "\n{";
  while (table.next_row()) {
    json += before;
    before = ",\n{";
    for (size_t c = 0; c < keys.size(); ++c)
      json += (c ? ", " : "") + keys[c] + json_cell(table.text(static_cast<int>(c)), is_name[c]);
    json += '}';
  }
  return json + "\n]\n";
}

std::string table_from_json(const std::string& json, const std::string& name) {
  YAML::Node rows;
  try {
    rows = YAML::Load(with_whole_characters(json));
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}:{}: is no JSON here; a table is a list of rows such as "
                    "{{\"pose\": \"1\", \"q1_deg\": 10}}",
                    name, error.mark.line + 1, error.mark.column + 1));
  }
  const std::vector<std::string> columns = columns_of(rows, name);
  std::string csv;
  for (const std::string& column : columns) csv += (csv.empty() ? "" : ",") + csv_cell(column);
  for (const YAML::Node& row : rows) {
    csv += '\n';
    for (size_t c = 0; c < columns.size(); ++c)
      csv += (c ? "," : "") + text_of_cell(row[columns[c]], columns[c], name);
  }
  return csv + '\n';
}

}  // namespace armtrue
