#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "armtrue/text/number_text.h"
#include "import/body_columns.h"
#include "import/instrument_tables.h"
#include "import/plain_cell.h"
#include "import/table_lines.h"

namespace armtrue {
namespace {

// A column of the table, with the body that it belongs to.
struct BodyColumn {
  size_t column;
  std::string body, name;
};

std::string chosen_body(const PlainTable& table, const std::string& stated,
                        const std::vector<std::string>& rigid,
                        const std::vector<std::string>& all) {
  if (!stated.empty()) {
    if (std::ranges::find(all, stated) != all.end()) return stated;
    table.fail_header(fmt::format("has no body or marker '{}' of --body; it has {}", stated,
                                  fmt::join(all, ", ")));
  }
  if (rigid.size() == 1) return rigid.front();
  if (rigid.empty() && all.size() == 1) return all.front();
  const std::vector<std::string>& names = rigid.empty() ? all : rigid;
  if (names.empty()) table.fail_header("has no body and no marker with positions; export them");
  table.fail_header(
      fmt::format("has several bodies or markers, {}; name the one that is on the robot: "
                  "--body NAME",
                  fmt::join(names, ", ")));
}

// Drops the columns of all bodies but the chosen one, which it returns.
std::string keep_one_body(PlainTable& table, const std::string& stated,
                          const std::vector<std::string>& rigid,
                          const std::vector<std::string>& all, std::vector<BodyColumn>& columns) {
  std::string chosen = chosen_body(table, stated, rigid, all);
  std::erase_if(columns, [&](const BodyColumn& column) { return column.body != chosen; });
  note_body(table, chosen, all);
  return chosen;
}

void add_name(std::vector<std::string>& names, const std::string& name) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

// The lines of Motive above that which begins with Frame.
struct MotiveHeader {
  std::map<std::string, std::string> properties;
  Cells types, names, kinds, axes;
};

MotiveHeader read_motive_header(TableLines& lines) {
  MotiveHeader header;
  if (!lines.next()) lines.fail("is empty; expected a CSV export of Motive");
  const Cells first = lines.cells(',');
  if (first.front() != "Format Version")
    lines.fail("begins with '" + first.front().substr(0, 40) +
               "' where an export of Motive has 'Format Version'; export it with its header");
  for (size_t k = 0; k + 1 < first.size(); k += 2) header.properties[first[k]] = first[k + 1];
  while (lines.next()) {
    if (lines.is_blank()) continue;
    Cells cells = lines.cells(',');
    if (cells.front() == "Frame") {
      header.axes = std::move(cells);
      break;
    }
    if (cells.size() < 2 || !cells.front().empty())
      lines.fail("begins with '" + cells.front().substr(0, 40) +
                 "' where the header of a Motive export goes on; export it with its header");
    if (cells[1] == "Type")
      header.types = std::move(cells);
    else if (cells[1] == "Name")
      header.names = std::move(cells);
    else if (cells[1].empty())
      header.kinds = std::move(cells);
  }
  if (header.axes.empty()) lines.fail("the header ends without the line that begins with 'Frame'");
  for (const Cells* row : {&header.types, &header.names, &header.kinds})
    if (row->size() != header.axes.size())
      lines.fail(fmt::format(
          "the lines Type, Name, Rotation or Position, and Frame need the same "
          "number of cells, and have {}, {}, {} and {}; export the file again",
          header.types.size(), header.names.size(), header.kinds.size(), header.axes.size()));
  return header;
}

void check_motive_properties(const TableLines& lines, const MotiveHeader& header,
                             bool has_rotation) {
  const auto require = [&](const char* key, const char* value, const char* remedy) {
    const auto found = header.properties.find(key);
    if (found == header.properties.end() || found->second == value) return;
    throw InputError(
        fmt::format("{}{} is '{}'; {}", at_line(lines.file(), 1), key, found->second, remedy));
  };
  if (has_rotation)
    require("Rotation Type", "Quaternion", "export with the rotation type Quaternion");
  require("Coordinate Space", "Global", "export in global coordinates");
}

std::vector<std::string> bodies_of(const std::vector<BodyColumn>& columns) {
  std::vector<std::string> names;
  for (const BodyColumn& column : columns) add_name(names, column.body);
  return names;
}

// ---- Vicon

// The rows of names, axes and units below the rate.
struct ViconHeader {
  double rate = 0;
  char separator = ',';
  Cells bodies, axes, units;
  bool is_trajectories = false;
};

ViconHeader read_vicon_header(TableLines& lines, std::string_view separators) {
  ViconHeader header;
  const auto section = [&](std::string_view name) { return lines.text().starts_with(name); };
  while (true) {
    if (!lines.next())
      lines.fail("has no line Objects, Segments or Trajectories; expected a CSV export of Vicon");
    header.is_trajectories = section("Trajectories");
    if (header.is_trajectories || section("Objects") || section("Segments")) break;
  }
  if (!lines.next()) lines.fail("the file ends where the rate of the frames should stand");
  const std::string rate(trimmed(lines.text().substr(0, lines.text().find_first_of(separators))));
  const auto number = plain_number(rate, '.');
  if (!number || !(number->value > 0))
    lines.fail("'" + rate + "' is no rate of frames; expected a number such as 100");
  header.rate = number->value;
  if (!lines.next()) lines.fail("the file ends where the names should stand");
  const std::string names(lines.text());
  const int names_line = lines.number();
  if (!lines.next()) lines.fail("the file ends where the header should stand");
  const std::string_view axes = lines.text();
  for (const char separator : separators)
    if (axes.starts_with(std::string("Frame") + separator)) header.separator = separator;
  header.axes = lines.cells(header.separator);
  if (header.axes.size() < 3 || header.axes[0] != "Frame" || header.axes[1] != "Sub Frame")
    lines.fail("expected the line that begins with Frame, Sub Frame; export the file again");
  const Cells named = split_cells(names, header.separator, at_line(lines.file(), names_line));
  for (size_t k = 0; k < header.axes.size(); ++k) {
    const bool is_new = k < named.size() && !named[k].empty();
    header.bodies.push_back(is_new ? named[k] : k == 0 ? "" : header.bodies.back());
  }
  if (!lines.next()) lines.fail("the file ends where the units should stand");
  header.units = lines.cells(header.separator);
  if (header.units.size() != header.axes.size())
    lines.fail(
        fmt::format("the line of units has {} where the header has {}; export the "
                    "file again",
                    counted(header.units.size(), "cell"), header.axes.size()));
  return header;
}

void require_cells(const TableLines& lines, const Cells& cells, size_t count, int header_line) {
  if (cells.size() != count)
    lines.fail(
        fmt::format("has {} where the header in line {} has {}; complete or remove "
                    "the row",
                    counted(cells.size(), "cell"), header_line, count));
}

PlainRow row_of(const TableLines& lines, const std::string& time, const Cells& cells,
                const std::vector<BodyColumn>& columns) {
  PlainRow row{lines.number(), {time}};
  for (const BodyColumn& column : columns) row.cells.push_back(cells[column.column]);
  return row;
}

// In either way to write decimals.
bool is_zero(const std::string& cell) {
  return std::ranges::any_of(std::string_view(".,"), [&](char sign) {
    const auto number = plain_number(cell, sign);
    return number && number->value == 0;
  });
}

// Empties the cells of a body or marker that was not seen: its rotation matrix or, where it has
// none, all its numbers are 0.
void blank_unseen(const std::vector<BodyColumn>& columns, PlainRow& row) {
  const auto is_of_matrix = [](const BodyColumn& column) {
    return column.name.starts_with("Rot[");
  };
  const bool has_matrix = std::ranges::any_of(columns, is_of_matrix);
  for (size_t k = 0; k < columns.size(); ++k)
    if ((!has_matrix || is_of_matrix(columns[k])) && !is_zero(row.cells[k + 1]))  // behind the time
      return;
  std::fill(row.cells.begin() + 1, row.cells.end(), "");
}

// A name that is in the list of the export but never in view: another one is on the robot, or the
// time is another.
void require_seen(const PlainTable& table, const std::string& body) {
  for (const PlainRow& row : table.rows)
    if (!std::all_of(row.cells.begin() + 1, row.cells.end(),
                     [](const std::string& cell) { return cell.empty(); }))
      return;
  table.fail_header(fmt::format(
      "'{}' is seen in none of the frames: its cells are empty or 0 in all rows; name another with "
      "--body, or export the frames in which it is seen",
      body));
}

// ---- Qualisys

// The column titles, each with its body; none of Frame, Time and the like.
struct QualisysHeader {
  Cells bodies, titles;
};

QualisysHeader read_qualisys_header(TableLines& lines) {
  constexpr const char* kExport =
      "; export from QTM to TSV with 'Include TSV header', 'Write column titles' and "
      "'Export time data for every frame'";
  if (!lines.next() ||
      !(lines.text().starts_with("NO_OF_FRAMES") || lines.text().starts_with("FILE_VERSION")))
    lines.fail(std::string("a file of Qualisys begins with NO_OF_FRAMES or FILE_VERSION") +
               kExport);
  Cells cells = lines.cells('\t');
  while (std::ranges::find(cells, "Time") == cells.end()) {
    if (cells[0] == "DATA_INCLUDED" && cells.size() > 1 && cells[1] != "3D" && cells[1] != "6D")
      lines.fail("holds '" + cells[1] + "' data; export 3D or 6D data");
    if (plain_number(cells[0], '.') || !lines.next())
      lines.fail(std::string("no line above the data names a column Time") + kExport);
    cells = lines.cells('\t');
  }
  QualisysHeader header;
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  std::string body;
  for (const std::string& cell : cells) {
    const size_t blank = cell.rfind(' ');
    if (blank != cell.npos) body = trimmed(cell.substr(0, blank));
    const bool is_of_all = cell == "Frame" || cell == "Time" || cell == "SMPTE";
    header.bodies.push_back(is_of_all ? "" : body);
    header.titles.push_back(blank == cell.npos ? cell : cell.substr(blank + 1));
  }
  return header;
}

}  // namespace

PlainTable read_motive(const std::string& path, const std::string& body) {
  TableLines lines(path);
  PlainTable table;
  table.file = lines.file();
  const MotiveHeader header = read_motive_header(lines);
  table.header_line = lines.number();
  std::vector<BodyColumn> columns;
  std::vector<std::string> rigid, all;
  for (size_t k = 2; k < header.axes.size(); ++k) {
    const std::string& kind = header.kinds[k];
    if ((kind != "Position" && kind != "Rotation") || header.axes[k].empty()) continue;
    columns.push_back({k, header.names[k], kind + " " + header.axes[k]});
    if (kind != "Position") continue;
    add_name(all, header.names[k]);
    if (header.types[k] == "Rigid Body") add_name(rigid, header.names[k]);
  }
  const std::string chosen = keep_one_body(table, body, rigid, all, columns);
  const bool has_rotation = std::ranges::any_of(
      columns, [](const BodyColumn& column) { return column.name.starts_with("Rotation"); });
  check_motive_properties(lines, header, has_rotation);
  const auto unit = header.properties.find("Length Units");
  table.columns.push_back({header.axes[1], ""});
  for (const BodyColumn& column : columns) {
    const bool is_length = column.name.starts_with("Position");
    table.columns.push_back(
        {column.name, is_length && unit != header.properties.end() ? unit->second : ""});
  }
  BlankLines blank;
  while (lines.next()) {
    if (blank.skips(lines, !table.rows.empty())) continue;
    const Cells cells = lines.cells(',');
    require_cells(lines, cells, header.axes.size(), table.header_line);
    table.rows.push_back(row_of(lines, cells[1], cells, columns));
  }
  require_rows(table);
  require_seen(table, chosen);
  return table;
}

// The times, which no cell of the export holds, get the decimal sign of the cells.
void write_times_like_cells(PlainTable& table) {
  const bool has_commas = std::ranges::any_of(table.rows, [](const PlainRow& row) {
    return std::any_of(row.cells.begin() + 1, row.cells.end(), [](const std::string& cell) {
      return decimal_evidence(cell) == DecimalEvidence::comma;
    });
  });
  if (!has_commas) return;
  for (PlainRow& row : table.rows) std::ranges::replace(row.cells.front(), '.', ',');
}

PlainTable read_vicon(const std::string& path, const std::string& separators,
                      const std::string& body) {
  TableLines lines(path);
  PlainTable table;
  table.file = lines.file();
  const ViconHeader header = read_vicon_header(lines, separators);
  table.header_line = lines.number() - 1;
  std::vector<BodyColumn> columns;
  for (size_t k = 2; k < header.axes.size(); ++k)
    if (!header.axes[k].empty()) columns.push_back({k, header.bodies[k], header.axes[k]});
  const std::string chosen = keep_one_body(table, body, {}, bodies_of(columns), columns);
  table.notes.push_back(fmt::format("times are frame / {:.9g} Hz", header.rate));
  table.columns.push_back({"Time", ""});
  for (const BodyColumn& column : columns)
    table.columns.push_back({column.name, header.units[column.column]});
  bool has_ended = false;  // a blank line ends the section
  while (lines.next()) {
    has_ended = has_ended || lines.is_blank();
    const Cells cells = lines.cells(header.separator);
    if (has_ended && !plain_number(cells[0], '.')) continue;
    if (has_ended)
      lines.fail(
          "a row follows a blank line; blank lines may only end a table. Remove it, or what "
          "follows it");
    require_cells(lines, cells, header.axes.size(), table.header_line);
    const auto frame = plain_number(cells[0], '.');
    if (!frame || cells[0].find_first_of(".,eE") != std::string::npos)
      lines.fail("column 'Frame': '" + cells[0] + "' is no whole number; correct the row");
    if (cells[1] != "0")
      lines.fail("column 'Sub Frame': '" + cells[1] +
                 "' is not 0; export the frames of the cameras alone");
    table.rows.push_back(row_of(lines, number_text(frame->value / header.rate), cells, columns));
    blank_unseen(columns, table.rows.back());
  }
  require_rows(table);
  require_seen(table, chosen);
  write_times_like_cells(table);
  return table;
}

PlainTable read_qualisys(const std::string& path, const std::string& body) {
  TableLines lines(path);
  PlainTable table;
  table.file = lines.file();
  const QualisysHeader header = read_qualisys_header(lines);
  table.header_line = lines.number();
  const size_t count = header.titles.size();
  const size_t time = std::ranges::find(header.titles, "Time") - header.titles.begin();
  std::vector<BodyColumn> columns;
  for (size_t k = 0; k < count; ++k)
    if (!header.bodies[k].empty()) columns.push_back({k, header.bodies[k], header.titles[k]});
  const std::string chosen = keep_one_body(table, body, {}, bodies_of(columns), columns);
  table.columns.push_back({"Time", ""});
  for (const BodyColumn& column : columns) table.columns.push_back({column.name, ""});
  BlankLines blank;
  while (lines.next()) {
    if (blank.skips(lines, !table.rows.empty())) continue;
    Cells cells = lines.cells('\t');
    if (cells.size() == count + 1 && cells.back().empty()) cells.pop_back();
    require_cells(lines, cells, count, table.header_line);
    table.rows.push_back(row_of(lines, cells[time], cells, columns));
    blank_unseen(columns, table.rows.back());
  }
  require_rows(table);
  require_seen(table, chosen);
  return table;
}

PlainTable read_instrument_table(const std::string& path, const Preset& preset,
                                 const std::string& body) {
  switch (preset.form) {
    case TableForm::spatial_analyzer:
      return read_spatial_analyzer(path);
    case TableForm::motive:
      return read_motive(path, body);
    case TableForm::qualisys:
      return read_qualisys(path, body);
    default:
      return read_vicon(path, preset.separators, body);
  }
}

}  // namespace armtrue
