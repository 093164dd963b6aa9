#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "armtrue/kinematics/names.h"
#include "armtrue/text/number_text.h"
#include "import/column_names.h"
#include "import/instrument_tables.h"
#include "import/table_lines.h"

namespace armtrue {
namespace {

bool has_decimals(const std::string& cell) {
  return plain_number(cell, '.') && cell.find_first_of(".eE") != std::string::npos;
}

// The time of a cell with date and time, in a form of plain_time(); a year of two digits, which
// SpatialAnalyzer writes behind slashes, gets the other two: 02/12/25 16:38:29.
std::optional<std::string> dated_time(std::string cell) {
  constexpr size_t kShortYear = 2;
  const size_t end = std::min(cell.find_first_not_of("0123456789/"), cell.size());
  const size_t slash = cell.substr(0, end).rfind('/');
  if (cell.find('/') <= kShortYear && end - slash - 1 == kShortYear) cell.insert(slash + 1, "20");
  for (const DateOrder order : {DateOrder::day_first, DateOrder::month_first})
    if (const auto time = plain_time(cell, order); time && time->has_date) return cell;
  return std::nullopt;
}

// Which number of a date with slashes is the day the file does not say; of one day the times are
// enough.
void drop_the_only_date(PlainTable& table) {
  const std::string& first = table.rows.front().cells.back();
  const std::string date = first.substr(0, first.find_last_of('/') + 5) + " ";
  const auto has_it = [&](const PlainRow& row) {
    const auto time = plain_time(row.cells.back(), DateOrder::day_first);
    return row.cells.back().starts_with(date) && !(time && time->has_zone);
  };
  constexpr size_t kLongestDay = 2;  // digits before the first slash: the year is last
  if (first.find('/') > kLongestDay || !std::ranges::all_of(table.rows, has_it)) return;
  for (PlainRow& row : table.rows) row.cells.back().erase(0, date.size());
}

std::string unit_of_axes(const TableLines& lines, const std::string& before) {
  const std::string_view text = lines.text();
  if (text.find("CARTESIAN") == std::string_view::npos)
    lines.fail("the coordinates are not Cartesian: '" + std::string(text.substr(0, 80)) +
               "'; export them as Cartesian coordinates");
  const size_t open = text.rfind('('), close = text.rfind(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return "";
  const std::string unit(trimmed(text.substr(open + 1, close - open - 1)));
  const auto known = find_unit(unit);
  if (!known || known->kind != UnitKind::length)
    lines.fail("the axes have the unit '" + unit + "', which is no length; export in mm");
  if (!before.empty() && before != unit)
    lines.fail("the axes have the units '" + before + "' and '" + unit +
               "' in one file; export each part into a file of its own");
  return unit;
}

// The last cell of the first row says whether times are exported.
void require_known_end(const TableLines& lines, const Cells& cells, bool has_time) {
  const std::string& cell = cells.back();
  if (has_time || plain_number(cell, '.') || cells.size() < 4) return;
  lines.fail(fmt::format(
      "ends with '{}', which is neither a coordinate nor a date and time such as "
      "02/12/25 16:38:29, 12/2/2025 4:38:29 PM or 2025-12-02 16:38:29; export it so, or without it",
      cell.substr(0, 60)));
}

void check_points(const PlainTable& table) {
  const int x = find_name(table.columns, "X").value();
  for (const PlainRow& row : table.rows)
    for (int k = x; k < x + 3; ++k)
      if (!has_decimals(row.cells[k]))
        table.fail(row, k,
                   "is no coordinate with decimals; the columns must be the names, X, Y, Z and, "
                   "last, date and time: export nothing else, and decimals");
  for (int k = 0; k < x; ++k) {
    const auto is_number = [&](const PlainRow& row) { return has_decimals(row.cells[k]); };
    if (std::ranges::all_of(table.rows, is_number))
      table.fail(table.rows.front(), k,
                 "looks like a coordinate where a name should stand; the columns must be the "
                 "names, X, Y, Z and, last, date and time: export nothing else");
  }
}

}  // namespace

PlainTable read_spatial_analyzer(const std::string& path) {
  TableLines lines(path);
  PlainTable table;
  table.file = lines.file();
  table.header_line = 1;
  std::string unit;
  size_t cells_of_row = 0;
  bool has_time = false;
  BlankLines blank;
  while (lines.next()) {
    if (blank.skips(lines, !table.rows.empty())) continue;
    if (lines.text().starts_with("//")) {
      if (lines.text().find("AXES") == std::string_view::npos) continue;
      unit = unit_of_axes(lines, unit);
      table.header_line = lines.number();
      continue;
    }
    Cells cells = lines.cells(',');
    if (table.rows.empty()) {
      cells_of_row = cells.size();
      has_time = dated_time(cells.back()).has_value();
      require_known_end(lines, cells, has_time);
      const size_t named = cells.size() - (has_time ? 1 : 0);
      if (named < 3 || named > 6)
        lines.fail(
            fmt::format("has {}: '{}'; expected up to three names, X, Y, Z and, last, "
                        "date and time, with commas between them: export so",
                        counted(cells.size(), "cell"), lines.text().substr(0, 60)));
      const std::array<const char*, 6> names{"Collection", "Group", "Point", "X", "Y", "Z"};
      for (size_t k = 6 - named; k < 6; ++k) table.columns.push_back({names[k], k < 3 ? "" : unit});
      if (has_time) table.columns.push_back({"Time", ""});
    }
    if (cells.size() != cells_of_row)
      lines.fail(
          fmt::format("has {} where the first row has {}: '{}'; complete or remove "
                      "the row",
                      counted(cells.size(), "cell"), cells_of_row, lines.text().substr(0, 60)));
    if (has_time) {
      const auto time = dated_time(cells.back());
      if (!time)
        lines.fail("'" + cells.back() + "' is no date and time as in the first row; correct it");
      cells.back() = *time;
    }
    table.rows.push_back({lines.number(), std::move(cells)});
  }
  require_rows(table);
  if (has_time) drop_the_only_date(table);
  for (PlainColumn& column : table.columns)
    if (column.name == "X" || column.name == "Y" || column.name == "Z") column.unit_row = unit;
  check_points(table);
  return table;
}

}  // namespace armtrue
