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
  char separator = ',';  ///< 0 for a recording, which is no text
  std::vector<PlainColumn> columns;
  std::vector<PlainRow> rows;
  bool has_markers = false;  ///< its column `target` names those of one row; see spread_markers()
  std::vector<std::string> notes;  ///< for the user: what of the file is not in the table

  /// file:line: column 'name': 'cell' what
  [[noreturn]] void fail(const PlainRow& row, int column, const std::string& what) const;
  /// The error of a column: it names the line of the header.
  [[noreturn]] void fail_header(const std::string& what) const;
};

/// How the tables of a format are written.
struct TableStyle {
  std::string separators = "\t;,";
  std::string comments = "#%/";  ///< signs that begin a comment; / means //
  bool blanks_too = true;        ///< as separators, where all names of the header are known
  int fewest_known = 3;          ///< names that tell a header from text: a point has three
};

/// Reads a table with one of the separators. The header is the first line with enough columns of
/// which `is_known` is true; what stands above it is text. A row of units may follow. Lines that
/// begin with a sign of a comment are comments. Throws InputError.
PlainTable read_plain_table(const std::string& path, const TableStyle& style,
                            const std::function<bool(std::string_view)>& is_known);

/// The cells of a line. Cells in quotes may hold separators; a quote in them is written twice.
/// Throws InputError, the message beginning with `where`.
std::vector<std::string> split_cells(std::string_view line, char separator,
                                     const std::string& where);

/// "file:line: ", with which a message begins.
std::string at_line(const std::string& file, int line);

}  // namespace armtrue
