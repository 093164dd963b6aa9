#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace armtrue {

struct PlainColumn {
  std::string name;      ///< as in the header, without blanks about it
  std::string unit_row;  ///< what stands below it in a row of units, if the table has one
};

struct PlainRow {
  int line = 0;
  std::vector<std::string> cells;
};

/// A table as instruments and controllers export it: text.
struct PlainTable {
  std::string file;
  int header_line = 0;
  char separator = ',';
  std::vector<PlainColumn> columns;
  std::vector<PlainRow> rows;

  /// file:line: column 'name': 'cell' what
  [[noreturn]] void fail(const PlainRow& row, int column, const std::string& what) const;
  /// The error of a column: it names the line of the header.
  [[noreturn]] void fail_header(const std::string& what) const;
};

/// Reads a table with one of `separators`. The header is the first line with three or more columns
/// of which `is_known` is true; what stands above it is text. A row of units may follow. Lines that
/// begin with #, // or % are comments. Throws InputError.
PlainTable read_plain_table(const std::string& path, const std::string& separators,
                            const std::function<bool(std::string_view)>& is_known);

}  // namespace armtrue
