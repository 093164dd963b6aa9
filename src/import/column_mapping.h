#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/import/import_io.h"
#include "armtrue/kinematics/joint_names.h"
#include "import/column_names.h"
#include "import/plain_cell.h"
#include "import/plain_table.h"
#include "import/presets.h"

namespace armtrue {

/// Behind the name of a link, the name of its joint where no URDF says another.
inline constexpr std::string_view kJointEnding = "_joint";

/// The names of the robot's joints in joint states, in the order of the chain; without a robot
/// none.
std::vector<std::string> joint_state_names(const ImportOptions& options);

/// ImportOptions, parsed. Throws InputError for a malformed option.
class ImportNames {
 public:
  explicit ImportNames(const ImportOptions& options);

  /// The format of the table; nothing for a plain table. Call apply_preset() once it is read.
  void set_preset(std::optional<Preset> preset) { preset_ = std::move(preset); }
  const Preset* preset() const { return preset_ ? &*preset_ : nullptr; }
  /// Assigns the columns of a table by the preset. If headers name joints without numbers, these
  /// are joints of the robot; without a robot their names must end in numbers. Without a preset the
  /// headers that have the names of the URDF's joints are these joints.
  void apply_preset(const PlainTable& table, const ImportOptions& options);

  /// True for a length or an angle that is known by its name, and for a column that an option
  /// names: such names distinguish a header from text above it.
  bool is_known(std::string_view header) const;
  bool is_ignored(const std::string& header) const;
  /// The assignment of a column by an option or the preset; null if there is none.
  const std::string* quantity_of(const std::string& header) const;
  const std::string* unit_of(const std::string& header) const;
  /// Whether the unit of the column is kOnlyByOption.
  bool doubts_unit_of(const std::string& header) const;
  /// Whether an option or the preset names a column of this table for a quantity.
  bool maps(const PlainTable& table, const std::string& quantity) const;
  /// The unit that --column states for an encoder value, such as mm of e1_mm=THEIRS; or empty.
  std::string stated_unit(const std::string& quantity) const;

  /// Throws InputError for an option that names a column of none of the tables.
  void check_all_found(const std::vector<const PlainTable*>& tables) const;

 private:
  void add_joints_of_urdf(const PlainTable& table);
  void add_joints_by_name(const PlainTable& table, const ImportOptions& options,
                          const std::map<std::string, std::string>& headers);

  std::map<std::string, std::string, std::less<>> quantities_, units_;  // by header
  std::map<std::string, std::string> stated_units_;                     // by quantity
  std::set<std::string> doubted_;
  std::vector<std::string> ignored_;  // a * at the end stands for any text
  std::vector<std::string> named_;    // by options
  std::map<std::string, std::string> of_urdf_;  // quantity by name of the joint
  std::optional<Preset> preset_;
};

enum class TableRole {
  readings,  ///< joint angles and points
  points,
  joints,  ///< poses in it come from the controller and are not used
  images,  ///< the same, one row for each image
  pass,    ///< samples of one motion: points, forces or both, and joint angles if it has them
};
constexpr bool has_points(TableRole role) {
  return role == TableRole::readings || role == TableRole::points || role == TableRole::pass;
}

struct MappedColumn {
  int column = 0;
  double factor = 1;  ///< from the unit of the column to m, rad, s
  std::string unit;
};

/// The encoder value of joint k is the quantity joints[k].column.
struct ColumnMapping {
  std::map<std::string, MappedColumn> columns;  ///< by quantity
  struct Note {
    std::string header, why;
  };
  std::vector<Note> unused;
  std::string orientation;        ///< see find_orientation()
  std::vector<JointName> joints;  ///< in the order of the chain; of a table of points none
  char decimal_sign = '.';
  bool decimal_stated = false;
  DateOrder date_order = DateOrder::day_first;  ///< of dates such as 3/5/2024

  const MappedColumn* find(const std::string& quantity) const;
  bool has(const std::string& quantity) const { return find(quantity) != nullptr; }
};

/// Which column of a table holds which quantity, in which unit. Throws InputError if this is
/// ambiguous or unknown.
ColumnMapping map_columns(const PlainTable& table, TableRole role, const ImportNames& names,
                          const ImportOptions& options);

/// The mapping as text, one line per column.
std::string mapping_text(const PlainTable& table, const ColumnMapping& mapping);

}  // namespace armtrue
