#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armtrue/io/source.h"
#include "armtrue/text/input_error.h"
#include "import/plain_cell.h"
#include "import/plain_table.h"

namespace armtrue {

/// Of one line.
using Cells = std::vector<std::string>;

/// The lines of a file, with the errors that name them.
class TableLines {
 public:
  explicit TableLines(const std::string& path) : source_(path) {}

  const std::string& file() const { return source_.name(); }
  int number() const { return source_.line_number(); }
  bool next() { return source_.next_line(line_); }
  std::string_view text() const { return line_; }
  bool is_blank() const { return trimmed(line_).empty(); }
  Cells cells(char separator) const {
    return split_cells(line_, separator, at_line(file(), number()));
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(at_line(file(), number()) + what);
  }

 private:
  Source source_;
  std::string_view line_;
};

/// The blank lines of a table stand at its end.
class BlankLines {
 public:
  /// True of a blank line; throws if a row follows one.
  bool skips(const TableLines& lines, bool has_rows) {
    if (lines.is_blank()) {
      if (!line_) line_ = lines.number();
      return true;
    }
    if (line_ && has_rows)
      throw InputError(at_line(lines.file(), line_) +
                       "blank line between rows; blank lines may only end a table. Remove it, or "
                       "what follows it");
    line_ = 0;
    return false;
  }

 private:
  int line_ = 0;
};

inline void require_rows(const PlainTable& table) {
  if (table.rows.empty()) table.fail_header("no row follows the header; export the readings too");
}

}  // namespace armtrue
