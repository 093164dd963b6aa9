#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/report/report.h"
#include "report/svg.h"

namespace armtrue {

/// Whether a result needs attention; each has a colour and a sign.
enum class Tone { good, attention, bad };

/// A text that the page words or rounds itself, marked with the path of its value in the product
/// (see Report). Page::value() shows a value as the product has it.
std::string keyed(const std::string& text, const std::string& key);

/// A value [SI] in a unit with four decimals, 0.1 um or 0.1 urad, never "-0.0000"; "-" if there is
/// none.
std::string keyed_value(const std::optional<double>& si, double unit, const std::string& key);

/// A share from 0 to 1, in per cent.
std::string keyed_share(double share, const std::string& key);

/// A row of cells, each HTML.
using TableRow = std::vector<std::string>;

/// Head and rows; the first column is of words, the others of numbers. It scrolls inside itself.
std::string table(const TableRow& head, const std::vector<TableRow>& rows);

/// A bar whose length shows a share from 0 to 1.
std::string share_bar(double share);

/// HTML that is hidden until the reader clicks on the summary.
std::string folded(const std::string& summary, const std::string& html);

/// `<p>` of HTML.
std::string paragraph(const std::string& html);

/// Builds a page. All texts are HTML, except those that are called plain.
class Page {
 public:
  /// `robot`: plain. `what`: kind of page, such as "Calibration", plain.
  Page(const PageHead& head, const std::string& robot, const std::string& what);

  /// The result in a word (plain) and in a sentence.
  void verdict(Tone tone, std::string word, const std::string& sentence);
  /// The few numbers that the reader looks for first.
  struct Tile {
    std::string label, value, note;
  };
  void tiles(const std::vector<Tile>& tiles);
  void section(const std::string& heading);
  /// A heading of parts that are folded; like them it is not printed.
  void folded_section(const std::string& heading);
  void add(const std::string& html) { body_ += html; }
  /// Adds pictures, side by side as far as there is room, also to Report::pictures. Null pointers
  /// are skipped.
  void pictures(const std::vector<Drawing>& pictures);
  void list(const std::vector<std::string>& items);

  /// Whether the product has a value at a path.
  bool has(const std::string& key) const { return head_.product.value(key) != nullptr; }
  /// The value at a path of the product, as it stands there; "-" where there is none. In mm or mrad
  /// a number below a tenth of a thousandth, which rounding makes, is 0.0000.
  std::string value(const std::string& key) const;
  /// The same for the name of a file; the line may break anywhere in it.
  std::string file_name(const std::string& key) const;
  /// The values of a list.
  std::vector<std::string> values(const std::string& list) const;
  /// The values of some keys of each entry of a list, up to one without the first key.
  std::vector<TableRow> rows(const std::string& list, const std::vector<std::string>& keys) const;
  /// A name, then mean, RMS, 95th percentile and maximum of the errors below a path.
  TableRow error_row(const std::string& name, const std::string& key) const;

  /// The input files with their SHA-256, and the command and version that made the page.
  std::string inputs() const;
  /// The whole page; `folds_inputs`: with the input files at its end, folded away.
  Report finish(bool folds_inputs = true);

 private:
  const PageHead& head_;
  std::string title_, body_;
  std::vector<PictureFile> files_;
};

}  // namespace armtrue
