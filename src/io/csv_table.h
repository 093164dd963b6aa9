#pragma once

#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/io/quantity_column.h"
#include "armtrue/io/source.h"

namespace armtrue {

/// A CSV file as armtrue-formats(5) describes it: one header row; comma and decimal point, or
/// semicolon and decimal comma (told from the header); CRLF, a BOM, blank lines at the end and
/// lines that begin with # are accepted. Rows are read one at a time. Errors throw InputError with
/// file, line, column and content.
class CsvTable {
 public:
  /// `header` is an example of a header row, for the error of an empty file.
  CsvTable(Source& source, std::string_view header);
  /// The rows of a block of the same file, see Source::next_block().
  CsvTable(const CsvTable& whole, Source& block)
      : source_(block), separator_(whole.separator_), columns_(whole.columns_) {}

  const std::vector<std::string>& columns() const { return columns_; }
  std::string source_name() const { return source_.name(); }
  std::optional<int> find(std::string_view column) const;

  using Quantity = QuantityColumn;
  /// The column of a quantity: find_length("x") finds `x_mm` or `x_m`.
  std::optional<Quantity> find_length(std::string_view name) const;  ///< _mm or _m, not both
  std::optional<Quantity> find_angle(std::string_view name) const;   ///< _deg or _rad, not both
  /// The column `in_unit`, with the factor `unit` to SI, or the column `in_si`. Throws InputError
  /// if the file has both.
  std::optional<Quantity> find_either(const std::string& in_unit, double unit,
                                      const std::string& in_si) const;

  /// Reads the next row of data; false at the end.
  bool next_row();
  int line_number() const { return source_.line_number(); }
  /// Line of a blank line after the last row, which only the end of the file may follow; 0: none.
  int blank_line() const { return blank_line_; }
  /// Throws the error of a blank line between rows.
  [[noreturn]] void fail_blank(int line) const;
  std::string_view text(int column) const { return fields_[column]; }
  bool is_empty(int column) const { return fields_[column].empty(); }
  double number(int column) const;
  double number(const Quantity& quantity) const { return quantity.unit * number(quantity.column); }
  int integer(int column) const;
  /// A time [s]. A time of day is refused with the remedy.
  double seconds(int column) const;

  /// The field as in the file, without quotes; text() replaces a decimal comma by a point.
  std::string_view original(int column) const;
  /// The same, 'quoted' for messages.
  std::string quoted(int column) const;
  char separator() const { return separator_; }
  /// file:line: column 'name': what
  [[noreturn]] void fail(int column, const std::string& what) const;
  [[noreturn]] void fail_in_line(int line, int column, const std::string& what) const;
  /// Throws the error of missing columns, with the most similar name of the file. `taken`: columns
  /// that are needed for something else. `what`: what needs the missing ones, for the message.
  [[noreturn]] void fail_missing(const std::vector<std::string>& missing,
                                 const std::set<int>& taken = {},
                                 const std::string& what = "") const;

 private:
  void split(std::string_view line, std::vector<std::string_view>& fields);
  size_t end_of_field(std::string_view line, size_t begin) const;
  bool has_open_quote() const;
  [[noreturn]] void fail_size(bool has_cell_of_lines) const;
  std::string_view unquoted(std::string_view field, size_t begin);

  Source& source_;
  char separator_ = ',';
  int blank_line_ = 0;
  bool ends_in_quote_ = false;  // has_open_quote() of the row before
  std::string_view original_;  // the line as it was read
  std::string line_;           // copy in which decimal commas are replaced
  std::vector<std::string> columns_;
  std::vector<std::string_view> fields_;
  std::deque<std::string> names_;  // of the row, those with doubled quotes; fields point to them
};

inline int column_of(int column) { return column; }
inline int column_of(const CsvTable::Quantity& quantity) { return quantity.column; }

/// The columns of one quantity: true if all of them are there, false if none is. Throws
/// fail_missing() if some are.
template <typename Columns>
bool has_all(const CsvTable& table, const Columns& found, std::span<const std::string> names,
             const std::string& what = "") {
  std::vector<std::string> missing;
  std::set<int> taken;
  for (size_t i = 0; i < names.size(); ++i)
    if (found[i])
      taken.insert(column_of(*found[i]));
    else
      missing.push_back(names[i]);
  if (taken.empty()) return false;
  if (!missing.empty()) table.fail_missing(missing, taken, what);
  return true;
}

}  // namespace armtrue
