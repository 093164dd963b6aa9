#include "import/plain_table.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "armtrue/io/source.h"
#include "armtrue/text/input_error.h"
#include "armtrue/text/number_text.h"
#include "import/column_names.h"
#include "import/plain_cell.h"

namespace armtrue {
namespace {

constexpr int kMostLinesAbove = 200;

bool is_comment(std::string_view line, const TableStyle& style) {
  if (line.empty() || style.comments.find(line.front()) == std::string::npos) return false;
  return line.front() != '/' || line.starts_with("//");
}

// Finds the header below other text, and the separator with which most of its names are known.
class HeaderSearch {
 public:
  HeaderSearch(const TableStyle& style, const std::function<bool(std::string_view)>& is_known)
      : style_(style), is_known_(is_known) {}

  bool try_line(std::string_view line, const std::string& where) {
    return by_signs(line, where) || (style_.blanks_too && by_blanks(line));
  }

  std::vector<std::string> cells;
  char found_separator = ',';

 private:
  bool by_signs(std::string_view line, const std::string& where) {
    long best = style_.fewest_known - 1;
    for (const char separator : style_.separators) {
      std::vector<std::string> names;
      try {
        names = split_cells(line, separator, where);
      } catch (const InputError&) {
        continue;  // text above the header
      }
      const long known = std::ranges::count_if(names, is_known_);
      if (known <= best) continue;
      best = known;
      cells = names;
      found_separator = separator;
    }
    return best >= style_.fewest_known;
  }

  // With blanks as separators all names must be known: text above a header may hold X, Y and Z
  // among other words.
  bool by_blanks(std::string_view line) {
    if (line.find('"') != std::string_view::npos) return false;
    const std::vector<std::string> names = split_cells(trimmed(line), ' ', "");
    const auto is_name = [&](const std::string& name) {
      return is_known_(name) || known_quantity(name).has_value();
    };
    if (std::ranges::count_if(names, is_known_) < style_.fewest_known ||
        !std::ranges::all_of(names, is_name))
      return false;
    cells = names;
    found_separator = ' ';
    return true;
  }

  const TableStyle& style_;
  const std::function<bool(std::string_view)>& is_known_;
};

std::string without_brackets(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && (text.front() == '[' || text.front() == '(') &&
      (text.back() == ']' || text.back() == ')'))
    text = text.substr(1, text.size() - 2);
  return std::string(trimmed(text));
}

// Every cell is a unit, empty or a dash.
bool is_unit_row(const std::vector<std::string>& cells) {
  int units = 0;
  for (const std::string& cell : cells) {
    const std::string unit = without_brackets(cell);
    if (unit.empty() || unit == "-") continue;
    if (!find_unit(unit)) return false;
    ++units;
  }
  return units > 0;
}

void refuse_row(const PlainTable& table, int line, size_t cells, std::string_view text) {
  const std::string what = at_line(table.file, line) + "has " + counted(cells, "cell") +
                           " where the header in line " + std::to_string(table.header_line) +
                           " has " + std::to_string(table.columns.size()) + ": '" +
                           std::string(text.substr(0, 60)) + "'; complete or remove the row";
  throw InputError(what + (table.separator == ',' && cells > table.columns.size()
                               ? "; decimal commas need quotes, or semicolons between the cells"
                               : ""));
}

// Whether a line is a row of a table without a header: three cells or more are numbers.
bool has_numbers(std::string_view line) {
  int numbers = 0;
  while (!line.empty()) {
    const size_t end = std::min(line.find_first_of(",;\t "), line.size());
    numbers += plain_number(line.substr(0, end), '.').has_value();
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return numbers >= 3;
}

void read_header(Source& source, const TableStyle& style, HeaderSearch& search, PlainTable& table) {
  std::string_view line;
  std::string first;
  while (source.next_line(line)) {
    if (trimmed(line).empty() || is_comment(line, style)) continue;
    if (first.empty()) first = line.substr(0, 60);
    if (source.line_number() > kMostLinesAbove) break;
    if (!search.try_line(line, at_line(table.file, source.line_number()))) continue;
    table.header_line = source.line_number();
    table.separator = search.found_separator;
    for (const std::string& name : search.cells) table.columns.push_back({name, ""});
    return;
  }
  if (first.empty())
    throw InputError(table.file + ": is empty; expected a table with a header row");
  throw InputError(
      at_line(table.file, 1) +
      "the table has no header row with known names, such as X,Y,Z, A1,...,A6 or, of a "
      "pass, Fx,Fy,Fz; the first "
      "line is '" +
      first + "'; say which column is which: --column x_mm=NAME, fx_n=NAME" +
      (has_numbers(first) ? ", or, if the file begins with numbers, put a line of names above them"
                          : ""));
}

// A separator at the end of each line makes an empty column without a name.
void drop_empty_last_column(PlainTable& table) {
  if (table.columns.empty() || !table.columns.back().name.empty()) return;
  if (!std::ranges::all_of(table.rows,
                           [](const PlainRow& row) { return row.cells.back().empty(); }))
    return;
  table.columns.pop_back();
  for (PlainRow& row : table.rows) row.cells.pop_back();
}

// What programs write in the place of a number that they do not have.
bool is_lost_number(std::string_view cell) {
  constexpr size_t kLongest = 7;
  if (cell.empty() || cell.size() > kLongest ||
      std::isdigit(static_cast<unsigned char>(cell.back())) != 0)
    return false;
  std::string word(cell);
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array<std::string_view, 7> kWords{"nan",  "#n/a", "n/a",    "na",
                                                   "null", "none", "#value!"};
  return std::ranges::find(kWords, word) != kWords.end() ||
         word.find_first_not_of('-') == std::string::npos;
}

// Empties these cells in columns of numbers; a name may be such a word.
void empty_lost_numbers(PlainTable& table) {
  for (size_t k = 0; k < table.columns.size(); ++k) {
    const auto told = std::ranges::find_if(table.rows, [&](const PlainRow& row) {
      return !row.cells[k].empty() && !is_lost_number(row.cells[k]);
    });
    if (told == table.rows.end() || decimal_evidence(told->cells[k]) == DecimalEvidence::no_number)
      continue;
    for (PlainRow& row : table.rows)
      if (is_lost_number(row.cells[k])) row.cells[k].clear();
  }
}

}  // namespace

std::string at_line(const std::string& file, int line) {
  return file + ":" + std::to_string(line) + ": ";
}

std::vector<std::string> split_cells(std::string_view line, char separator,
                                     const std::string& where) {
  std::vector<std::string> cells;
  if (separator != ' ') cells.reserve(1 + std::ranges::count(line, separator));
  size_t at = 0;
  while (true) {
    while (at < line.size() && line[at] == ' ') ++at;
    std::string cell;
    if (at < line.size() && line[at] == '"') {
      for (++at;; ++at) {
        if (at >= line.size())
          throw InputError(where + "a quote is not closed: '" + std::string(line.substr(0, 60)) +
                           "'; close or remove it");
        if (line[at] == '"' && (at + 1 >= line.size() || line[++at] != '"')) break;
        cell += line[at];
      }
      if (at < line.size() && line[at] == '"') ++at;
      while (at < line.size() && line[at] == ' ' && separator != ' ') ++at;
      if (at < line.size() && line[at] != separator)
        throw InputError(where + "text stands behind a closed quote: '" +
                         std::string(line.substr(0, 60)) + "'; correct the quotes");
    } else {
      const size_t end = std::min(line.find(separator, at), line.size());
      cell = line.substr(at, end - at);
      at = end;
    }
    cells.emplace_back(trimmed(cell));
    if (at >= line.size()) return cells;
    ++at;
  }
}

void PlainTable::fail(const PlainRow& row, int column, const std::string& what) const {
  const size_t index = column;
  throw InputError(at_line(file, row.line) + "column '" + columns[index].name + "': '" +
                   row.cells[index] + "' " + what);
}

void PlainTable::fail_header(const std::string& what) const {
  throw InputError(at_line(file, header_line) + what);
}

PlainTable read_plain_table(const std::string& path, const TableStyle& style,
                            const std::function<bool(std::string_view)>& is_known) {
  Source source(path);
  PlainTable table;
  table.file = source.name();
  HeaderSearch search(style, is_known);
  read_header(source, style, search, table);
  std::string_view line;
  int blank_line = 0;
  for (bool first = true; source.next_line(line);) {
    const int number = source.line_number();
    if (line.find_first_not_of(std::string(" \t\"") + table.separator) == std::string_view::npos) {
      blank_line = number;
      continue;
    }
    if (is_comment(line, style)) continue;
    if (blank_line && !first)
      throw InputError(at_line(table.file, blank_line) +
                       "blank line between rows; blank lines may only end a table. Remove it, or "
                       "what follows it");
    if (table.separator == ' ') line = trimmed(line);
    PlainRow row{number, split_cells(line, table.separator, at_line(table.file, number))};
    // Some programs end the rows with a separator, but not the header.
    while (row.cells.size() > table.columns.size() && row.cells.back().empty())
      row.cells.pop_back();
    if (row.cells.size() != table.columns.size()) refuse_row(table, number, row.cells.size(), line);
    if (first && is_unit_row(row.cells)) {
      for (size_t k = 0; k < row.cells.size(); ++k)
        table.columns[k].unit_row = without_brackets(row.cells[k]);
    } else {
      table.rows.push_back(std::move(row));
    }
    first = false;
    blank_line = 0;
  }
  if (table.rows.empty()) table.fail_header("no row follows the header; export the readings too");
  drop_empty_last_column(table);
  empty_lost_numbers(table);
  return table;
}

}  // namespace armtrue
