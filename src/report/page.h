#pragma once

#include <string>
#include <vector>

#include "armtrue/report/report.h"
#include "armtrue/statistics/summary.h"
#include "report/svg.h"

namespace armtrue {

/// Whether a result needs attention; each has a colour and a sign.
enum class Tone { good, attention, bad };

/// A value with its path in the product (see Report).
std::string keyed(const std::string& text, const std::string& key);

/// A length [m] in mm; below the tenth of a micrometre it is 0.
std::string keyed_mm(double metres, const std::string& key);

/// A share, of 1 in the product, in per cent.
std::string keyed_share(double share, const std::string& key);

/// The same of a number with the four digits that products have of statistics.
std::string keyed(double value, const std::string& key);

/// A file name or another text whose parts are long: may be broken anywhere.
std::string breakable(const std::string& text);

/// A row of cells, each HTML.
using TableRow = std::vector<std::string>;

/// A name, then mean, RMS, 95th percentile and maximum of errors [SI] in a unit, keyed below `key`.
TableRow error_cells(const std::string& name, const ErrorSummary& errors, double unit,
                     const std::string& key);

/// Head and rows; the first column is of words, the others of numbers. It scrolls inside itself.
std::string table(const TableRow& head, const std::vector<TableRow>& rows);

/// A bar as long as a share of 1.
std::string share_bar(double share);

/// Hidden until the reader asks for it.
std::string folded(const std::string& summary, const std::string& html);

/// `<p>` of HTML.
std::string paragraph(const std::string& html);

/// One page in one style. All texts are HTML but where it says "plain".
class Page {
 public:
  /// `robot`: plain. `what`: kind of page, as "Calibration", plain.
  Page(const PageHead& head, const std::string& robot, const std::string& what);

  /// The result in a word (plain) and in a sentence.
  void verdict(Tone tone, const std::string& word, const std::string& sentence);
  /// The few numbers that the reader looks for first.
  struct Tile {
    std::string label, value, note;
  };
  void tiles(const std::vector<Tile>& tiles);
  void section(const std::string& heading);
  /// Of what is folded, and so not printed.
  void folded_section(const std::string& heading);
  void add(const std::string& html) { body_ += html; }
  /// Beside each other as far as there is room; kept for Report::pictures. Null: left out.
  void pictures(const std::vector<Drawing>& pictures);
  void list(const std::vector<std::string>& items);

  /// The input files with their SHA-256, and what made the page.
  std::string inputs() const;
  /// The whole page; `folds_inputs`: with the input files at its end, folded away.
  Report finish(bool folds_inputs = true);

 private:
  const PageHead& head_;
  std::string title_, body_;
  std::vector<PictureFile> files_;
};

}  // namespace armtrue
