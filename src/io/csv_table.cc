#include "io/csv_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <utility>

#include "armtrue/kinematics/names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "armtrue/text/text_parts.h"

namespace armtrue {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

size_t end_at(char separator, std::string_view line, size_t begin) {
  return std::min(line.find(separator, begin), line.size());
}

// A name without its unit and case: most mistakes are in these.
std::string stem(const std::string& name) {
  return lower_case(name.substr(0, name.rfind('_')));
}

// q1deg and Q1 [deg] are q1_deg.
bool are_alike(const std::string& a, const std::string& b) {
  const auto letters = [](std::string name) {
    std::erase_if(name, [](unsigned char c) { return c < 0x80 && !std::isalnum(c); });
    return lower_case(name);
  };
  return letters(a) == letters(b);
}

// Q3 is nearer to q3_deg than q1_deg is, which is another joint's column.
int distance_without_unit(const std::string& a, const std::string& b) {
  if (are_alike(a, b)) return 0;
  const auto number = [](std::string name) {
    std::erase_if(name, [](unsigned char c) { return !std::isdigit(c); });
    return name;
  };
  return edit_distance(stem(a), stem(b)) + (number(a) == number(b) ? 0 : 2);
}

// At most two edits apart, with at least one letter right.
bool may_be_a_slip(const std::string& a, const std::string& b) {
  const auto longest = static_cast<int>(std::max(stem(a).size(), stem(b).size()));
  return distance_without_unit(a, b) <= std::min(2, longest - 1);
}

// q1_deg, e2_mm
bool names_an_axis(const std::string& name) {
  return name.size() > 1 && (name[0] == 'q' || name[0] == 'e') && name[1] >= '0' && name[1] <= '9';
}

}  // namespace

CsvTable::CsvTable(Source& source, std::string_view header) : source_(source) {
  source_.take_json_as_table();
  std::string_view line;
  do {
    if (!source_.next_line(line))
      throw InputError(source_.name() + ": is empty; expected a header row such as " +
                       std::string(header));
  } while (trimmed(line).empty() || line.front() == '#');
  if (line.starts_with('<'))
    throw InputError(source_.name() + ":" + std::to_string(source_.line_number()) +
                     ": is HTML or XML, and a CSV table should stand here; open it in a "
                     "spreadsheet and save it as CSV");
  if (line.starts_with("format:") || line.starts_with('{'))
    throw InputError(source_.name() + ":" + std::to_string(source_.line_number()) +
                     ": is a document, such as a robot file; a table should stand here that begins "
                     "with a row such as " +
                     std::string(header));
  separator_ = line.find(';') != std::string_view::npos ? ';' : ',';
  std::vector<std::string_view> names;
  original_ = line;
  split(line, names);
  const auto numbers = std::ranges::count_if(
      names, [](std::string_view name) { return read_number(name).has_value(); });
  if (2 * numbers > std::ssize(names))
    throw InputError(source_.name() + ":" + std::to_string(source_.line_number()) +
                     ": numbers stand where the header row should: '" +
                     std::string(line.substr(0, 60)) + "'; begin the file with a row such as " +
                     std::string(header));
  for (std::string_view name : names) {
    if (std::find(columns_.begin(), columns_.end(), name) != columns_.end())
      throw InputError(
          source_.name() + ":" + std::to_string(source_.line_number()) + ": " +
          (name.empty()
               ? "two columns have no name; name or remove them, or convert an exported table "
                 "with import-readings (of a pass: --pass)"
               : "the column '" + std::string(name) + "' stands twice; remove one"));
    columns_.emplace_back(name);
  }
}

// A separator between quotes belongs to the field. Quotes that do not end are characters like others.
size_t CsvTable::end_of_field(std::string_view line, size_t begin) const {
  size_t first = begin;
  while (first < line.size() && is_blank(line[first])) ++first;
  if (first < line.size() && line[first] == '"') {
    size_t quote = line.find('"', first + 1);
    while (quote != std::string_view::npos && line.substr(quote, 2) == "\"\"")
      quote = line.find('"', quote + 2);
    if (quote != std::string_view::npos) {
      const size_t end = std::min(line.find_first_not_of(" \t", quote + 1), line.size());
      if (end == line.size() || line[end] == separator_) return end;
    }
  }
  return end_at(separator_, line, begin);
}

// `begin`: of the field in its line.
std::string_view CsvTable::unquoted(std::string_view field, size_t begin) {
  if (field.size() < 2 || field.front() != '"' || field.back() != '"') return field;
  const std::string_view inside = field.substr(1, field.size() - 2);
  if (inside.find('"') == std::string_view::npos) return inside;
  std::string& name = names_.emplace_back(original_.substr(begin + 1, inside.size()));
  for (size_t at = name.find("\"\""); at != std::string::npos; at = name.find("\"\"", at + 1))
    name.erase(at, 1);
  return name;
}

void CsvTable::split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  names_.clear();
  const bool has_quotes = line.find('"') != std::string_view::npos;
  size_t begin = 0;
  while (true) {
    const size_t end = has_quotes ? end_of_field(line, begin) : end_at(separator_, line, begin);
    const std::string_view field = trimmed(line.substr(begin, end - begin));
    fields.push_back(has_quotes ? unquoted(field, field.data() - line.data()) : field);
    if (end == line.size()) return;
    begin = end + 1;
  }
}

std::optional<int> CsvTable::find(std::string_view column) const {
  return find_name(columns_, column);
}

std::optional<CsvTable::Quantity> CsvTable::find_length(std::string_view name) const {
  return find_either(std::string(name) + "_mm", kMillimetre, std::string(name) + "_m");
}

std::optional<CsvTable::Quantity> CsvTable::find_angle(std::string_view name) const {
  return find_either(std::string(name) + "_deg", kDegree, std::string(name) + "_rad");
}

std::optional<CsvTable::Quantity> CsvTable::find_either(const std::string& in_unit, double unit,
                                                        const std::string& in_si) const {
  const std::optional<int> column = find(in_unit), other = find(in_si);
  if (column && other) fail(*other, "stands beside '" + in_unit + "'; keep one of them");
  if (column) return Quantity{*column, unit};
  if (other) return Quantity{*other, 1.0};
  return std::nullopt;
}

bool CsvTable::next_row() {
  std::string_view line;
  while (source_.next_line(line)) {
    if (!line.empty() && line.front() == '#') continue;
    if (trimmed(line).empty()) {
      blank_line_ = source_.line_number();
      continue;
    }
    if (blank_line_ != 0) fail_blank(blank_line_);
    original_ = line;
    if (separator_ == ';') {
      line_ = line;
      std::replace(line_.begin(), line_.end(), ',', '.');
      line = line_;
    }
    split(line, fields_);
    const bool goes_on = std::exchange(ends_in_quote_, has_open_quote());
    if (fields_.size() != columns_.size()) fail_size(goes_on || ends_in_quote_);
    return true;
  }
  return false;
}

// Whether the row ends in a quote that does not end, as the first line of a cell of several lines.
bool CsvTable::has_open_quote() const {
  const std::string_view last = fields_.back();
  return last.starts_with('"') && !(last.size() > 1 && last.ends_with('"'));
}

std::string_view CsvTable::original(int column) const {
  const std::string_view field = fields_[column];
  if (std::ranges::any_of(names_, [&](const auto& name) { return name.data() == field.data(); }))
    return field;
  const char* const read = separator_ == ';' ? line_.data() : original_.data();
  return original_.substr(field.data() - read, field.size());
}

std::string CsvTable::quoted(int column) const { return "'" + std::string(original(column)) + "'"; }

void CsvTable::fail(int column, const std::string& what) const {
  fail_in_line(source_.line_number(), column, what);
}

void CsvTable::fail_in_line(int line, int column, const std::string& what) const {
  throw InputError(source_.name() + ":" + std::to_string(line) + ": column '" + columns_[column] +
                   "': " + what);
}

void CsvTable::fail_size(bool has_cell_of_lines) const {
  throw InputError(source_.name() + ":" + std::to_string(source_.line_number()) + ": has " +
                   counted(fields_.size(), "field") + " where the header has " +
                   std::to_string(columns_.size()) + ": '" + std::string(original_.substr(0, 60)) +
                   "'; " +
                   (has_cell_of_lines ? "a cell in quotes holds a line end, and a row is one line: "
                                        "take it out of the cell"
                                      : "complete or remove the row"));
}

void CsvTable::fail_blank(int line) const {
  throw InputError(source_.name() + ":" + std::to_string(line) +
                   ": blank line between rows; blank lines may only end a file");
}

void CsvTable::fail_missing(const std::vector<std::string>& missing, const std::set<int>& taken,
                            const std::string& what) const {
  std::string message = source_.name() + ": " +
                        (what.empty() ? "missing" : what + " also needs the") + " column" +
                        (missing.size() > 1 ? "s" : "");
  for (size_t i = 0; i < missing.size(); ++i)
    message += (i ? ", " : " ") + ("'" + missing[i] + "'");
  const bool one = missing.size() == 1;
  std::string remedy =
      one ? "; name the column so, or add it." : "; name the columns so, or add them.";
  if (std::ranges::all_of(missing, names_an_axis))
    remedy =
        one ? "; the robot has this axis: name the column so, add it, or give the robot of this "
              "table."
            : "; the robot has these axes: name the columns so, add them, or give the robot of "
              "this table.";
  constexpr size_t kOfAnExport = 3;  // with so many missing, another program wrote the table
  const bool is_export = missing.size() >= kOfAnExport && what.empty();
  if (is_export)
    remedy = std::string("; convert an exported table with ") +
             (std::ranges::count(missing, "t_s")
                  ? "import-readings --pass, a robot program with import-readings --program"
                  : "import-readings, which asks for the units") +
             ", or name the columns so.";
  if (columns_.size() == 1 && columns_.front().find('\t') != std::string::npos)
    remedy = "; separate them by commas or semicolons, not by tabs.";
  std::vector<std::string> candidates;
  for (int c = 0; c < std::ssize(columns_); ++c)
    if (!taken.contains(c)) candidates.push_back(columns_[c]);
  for (const std::string& name : missing) {
    const auto nearest =
        std::ranges::min_element(candidates, {}, [&](const std::string& candidate) {
          return std::pair(distance_without_unit(candidate, name), edit_distance(candidate, name));
        });
    const bool is_slip = nearest != candidates.end() && may_be_a_slip(*nearest, name);
    // In an export a name that is near may have another unit.
    if (is_slip && (!is_export || are_alike(*nearest, name))) {
      remedy = "; is '" + *nearest + "' meant to be '" + name + "'?";
      break;
    }
  }
  throw InputError(message + remedy + " The header has: " + [&] {
    std::string list;
    for (const std::string& column : columns_) list += (list.empty() ? "" : ",") + column;
    return list;
  }());
}

double CsvTable::number(int column) const {
  const std::optional<double> read = read_number(fields_[column]);
  if (!read) fail(column, quoted(column) + " is no number; correct it or remove the row");
  const double value = *read;
  if (!std::isfinite(value))
    fail(column, quoted(column) + " is not finite; correct it or remove the row");
  if (std::abs(value) > kMaxNumber)
    fail(column,
         quoted(column) + " is larger than anything measured; correct it or remove the row");
  return value;
}

double CsvTable::seconds(int column) const {
  if (fields_[column].find(':') != std::string_view::npos)
    fail(column, quoted(column) +
                     " is a time of day, not a number of seconds; write seconds since the first "
                     "row (import-readings does so with measured poses)");
  return number(column);
}

int CsvTable::integer(int column) const {
  const double value = number(column);
  if (value != std::floor(value) || std::abs(value) > 2e9)
    fail(column, quoted(column) + " is no whole number");
  return static_cast<int>(value);
}

}  // namespace armtrue
