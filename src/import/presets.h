#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace armtrue {

/// How the files of a preset name their columns.
enum class TableForm {
  header,            ///< in one line, as a plain table
  spatial_analyzer,  ///< not at all, see read_spatial_analyzer()
  motive,            ///< in several lines, see read_motive()
  vicon,             ///< in several lines, see read_vicon()
  qualisys,          ///< below lines of facts, see read_qualisys()
};

/// Unit of columns whose header may state a wrong one: only an option says it.
inline constexpr std::string_view kOnlyByOption = "by option";

struct PresetColumn {
  /// `*` stands for any text, {joint} for the name of a joint, {k} for a number counted from 0, {n}
  /// for one counted from 1. Capital letters and brackets at the end do not count.
  std::string header;
  /// As in column_names.h; "q" is the encoder value of that joint, "cov" that entry of a
  /// covariance.
  std::string quantity;
  std::string unit;  ///< empty: the file or an option says it; see kOnlyByOption
  /// Holds only in a table that has this column too; for {k}: the columns whose cells name the
  /// joints, without the number.
  std::string beside;
};

/// A format that instruments, controllers or recorders write. The first column that fits a quantity
/// holds it; what no column fits is not used.
struct Preset {
  std::string name;
  bool holds_joints = false;  ///< of the table of joint angles; otherwise of the points
  TableForm form = TableForm::header;
  std::string separators;
  std::string comments;       ///< signs that begin a line of comment
  bool is_sparse = false;     ///< rows without any joint angle belong to other columns
  std::vector<PresetColumn> columns;
};

/// The shipped ones, config/presets.
const std::vector<Preset>& presets();
/// Null if there is none of this name.
const Preset* find_preset(std::string_view name);
/// Reads a document `armtrue-preset/1`, see armtrue-formats(5). Throws InputError.
Preset parse_preset(const std::string& text, const std::string& file);
Preset read_preset(const std::string& path);

/// What a preset says of a header.
struct PresetFit {
  const PresetColumn* column = nullptr;  ///< null if nothing
  std::string captured;                  ///< what stands for {joint}, {k} or {n}
};
PresetFit fit_of(const PresetColumn& column, std::string_view header);
bool is_in_preset(const Preset& preset, std::string_view header);

}  // namespace armtrue
