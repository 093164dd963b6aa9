#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "armtrue/kinematics/names.h"
#include "import/column_names.h"
#include "import/instrument_tables.h"
#include "import/table_lines.h"

namespace armtrue {
namespace {

bool has_decimals(const std::string& cell) {
  return plain_number(cell, '.') && cell.find_first_of(".eE") != std::string::npos;
}

struct DateAndTime {
  std::string date, time;
};

// 02/12/25 16:38:29, whose year has two digits or four.
std::optional<DateAndTime> date_and_time(const std::string& cell) {
  constexpr size_t kShortYear = 2;
  const size_t blank = cell.rfind(' ');
  if (blank == std::string::npos || std::ranges::count(cell, '/') != 2) return std::nullopt;
  if (cell.find_first_not_of("0123456789/") != blank) return std::nullopt;
  DateAndTime found{cell.substr(0, blank), cell.substr(blank + 1)};
  const size_t year = found.date.rfind('/') + 1;
  if (found.date.size() - year == kShortYear) found.date.insert(year, "20");
  return plain_time(found.time) ? std::optional(found) : std::nullopt;
}

// Which number of a date is the day the file does not say; of one day the times are enough.
void put_dates_before_times(const std::vector<std::string>& dates, std::vector<PlainRow>& rows) {
  if (std::ranges::adjacent_find(dates, std::ranges::not_equal_to()) == dates.end()) return;
  for (size_t r = 0; r < rows.size(); ++r)
    rows[r].cells.back() = dates[r] + " " + rows[r].cells.back();
}

std::string unit_of_axes(const TableLines& lines, const std::string& before) {
  const std::string_view text = lines.text();
  if (text.find("CARTESIAN") == std::string_view::npos)
    lines.fail("the coordinates are not Cartesian: '" + std::string(text.substr(0, 80)) +
               "'; export them as Cartesian coordinates");
  const size_t open = text.rfind('('), close = text.rfind(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return "";
  const std::string unit(trim_blanks(text.substr(open + 1, close - open - 1)));
  const auto known = find_unit(unit);
  if (!known || known->kind != UnitKind::length)
    lines.fail("the axes have the unit '" + unit + "', which is no length; export in mm");
  if (!before.empty() && before != unit)
    lines.fail("the axes have the units '" + before + "' and '" + unit +
               "' in one file; export each part into a file of its own");
  return unit;
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
  std::vector<std::string> dates;  // of the rows
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
      has_time = date_and_time(cells.back()).has_value();
      const size_t named = cells.size() - (has_time ? 1 : 0);
      if (named < 3 || named > 6)
        lines.fail(
            fmt::format("has {} cells: '{}'; expected up to three names, X, Y, Z and, last, "
                        "date and time, with commas between them: export so",
                        cells.size(), lines.text().substr(0, 60)));
      const std::array<const char*, 6> names{"Collection", "Group", "Point", "X", "Y", "Z"};
      for (size_t k = 6 - named; k < 6; ++k) table.columns.push_back({names[k], k < 3 ? "" : unit});
      if (has_time) table.columns.push_back({"Time", ""});
    }
    if (cells.size() != cells_of_row)
      lines.fail(
          fmt::format("has {} cells where the first row has {}: '{}'; complete or remove "
                      "the row",
                      cells.size(), cells_of_row, lines.text().substr(0, 60)));
    if (has_time) {
      const auto time = date_and_time(cells.back());
      if (!time)
        lines.fail("'" + cells.back() + "' is no date and time as in the first row; correct it");
      cells.back() = time->time;
      dates.push_back(time->date);
    }
    table.rows.push_back({lines.number(), std::move(cells)});
  }
  require_rows(table);
  put_dates_before_times(dates, table.rows);
  for (PlainColumn& column : table.columns)
    if (column.name == "X" || column.name == "Y" || column.name == "Z") column.unit_row = unit;
  check_points(table);
  return table;
}

}  // namespace armtrue
