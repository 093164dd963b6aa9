#include "io/table_json.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
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

constexpr const char* kRow = R"({"pose": "1", "q1_deg": 10})";

// Takes the events of a list of rows; no tree of nodes takes memory for it.
class RowReader : public YAML::EventHandler {
 public:
  explicit RowReader(std::string name) : name_(std::move(name)) {}

  // Columns in the order in which rows have them first.
  std::string csv() const {
    if (columns_.empty()) throw InputError(name_ + ": is an empty list; a table needs a row");
    std::string csv;
    for (const std::string& column : columns_) csv += (csv.empty() ? "" : ",") + csv_cell(column);
    for (const std::vector<std::string>& row : rows_) {
      csv += '\n';
      for (size_t c = 0; c < columns_.size(); ++c)
        csv += (c ? "," : "") + (c < row.size() ? row[c] : "");
    }
    return csv + '\n';
  }

 private:
  using Mark = YAML::Mark;
  using Anchor = YAML::anchor_t;
  using Style = YAML::EmitterStyle::value;
  static constexpr int kInList = 1, kInRow = 2;

  [[noreturn]] void fail(const Mark& mark, const std::string& why) const {
    throw InputError(fmt::format("{}:{}: {}", name_, mark.line + 1, why));
  }

  void require_row(const Mark& mark) const {
    if (depth_ != kInRow)
      fail(mark, fmt::format("entry {} of the list is no row such as {}", rows_.size() + 1, kRow));
  }

  [[noreturn]] void fail_value(const Mark& mark) const {
    fail(mark, fmt::format("'{}' holds no single value; a cell of a table is a number, a text of "
                           "one line or null",
                           key_.value_or("")));
  }

  void take(const Mark& mark, const std::string& text) {
    require_row(mark);
    if (!key_) {
      const auto [found, is_new] = index_.try_emplace(text, columns_.size());
      if (is_new) columns_.push_back(text);
      column_ = found->second;
      if (!has_.insert(column_).second)
        fail(mark, fmt::format("'{}' stands twice in a row; remove one", text));
      key_ = text;
      return;
    }
    if (text.find_first_of("\r\n") != std::string::npos) fail_value(mark);
    std::vector<std::string>& row = rows_.back();
    row.resize(std::max(row.size(), column_ + 1));
    row[column_] = csv_cell(text);
    key_.reset();
  }

  void OnDocumentStart(const Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const Mark& mark, Anchor) override { take(mark, ""); }
  void OnAlias(const Mark& mark, Anchor) override { fail_value(mark); }
  void OnScalar(const Mark& mark, const std::string&, Anchor, const std::string& text) override {
    take(mark, text);
  }
  void OnSequenceStart(const Mark& mark, const std::string&, Anchor, Style) override {
    if (depth_ == kInRow) fail_value(mark);
    if (depth_ == kInList) require_row(mark);
    ++depth_;
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const Mark& mark, const std::string&, Anchor, Style) override {
    if (depth_ == kInRow) fail_value(mark);
    ++depth_;
    rows_.emplace_back();
    has_.clear();
  }
  void OnMapEnd() override { --depth_; }

  const std::string name_;
  int depth_ = 0;
  std::vector<std::string> columns_;
  std::map<std::string, size_t> index_;
  std::vector<std::vector<std::string>> rows_;
  std::set<size_t> has_;            // columns of the last row
  std::optional<std::string> key_;  // whose value comes next
  size_t column_ = 0;
};

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
  RowReader reader(name);
  try {
    std::istringstream text(with_whole_characters(json));
    YAML::Parser parser(text);
    parser.HandleNextDocument(reader);
    const size_t end = json.find_last_not_of(" \t\r\n");
    RowReader more(name);
    if (json[end] != ']' || parser.HandleNextDocument(more))
      throw InputError(name + ": more stands behind the list of rows; give one list");
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}:{}: is no JSON here; a table is a list of rows such as {}",
                                 name, error.mark.line + 1, error.mark.column + 1, kRow));
  }
  return reader.csv();
}

}  // namespace armtrue
