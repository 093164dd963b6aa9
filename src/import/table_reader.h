#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "import/column_mapping.h"
#include "import/plain_cell.h"

namespace armtrue {

/// Times above it count from 1970 [s]: a clock that began at 0 is below for three years.
inline constexpr double kFrom1970 = 1e8;

/// The cells of one table by quantity, in m, rad, s. Errors throw InputError with file, line,
/// column, content and remedy.
class TableReader {
 public:
  TableReader(const PlainTable& table, const ColumnMapping& mapping);

  const PlainTable& table() const { return table_; }
  bool has(const std::string& quantity) const { return mapping_.has(quantity); }
  bool has_orientation() const { return !mapping_.orientation.empty(); }
  const std::vector<JointName>& joint_names() const { return mapping_.joints; }
  std::vector<std::string> quantities() const;
  int rows() const { return static_cast<int>(table_.rows.size()); }
  const PlainRow& row(int r) const { return table_.rows[r]; }

  const std::string& cell(int r, const std::string& quantity) const;
  double number(int r, const std::string& quantity) const;
  int whole_number(int r, const std::string& quantity) const;
  /// A name as a CSV file can hold it without quotes.
  const std::string& name(int r, const std::string& quantity) const;
  /// Joint angles of a measured row [rad or m].
  JointVector joints(int r) const;
  /// Moves joint angles by whole turns into the travel of the robot (move_into_travel()). Returns a
  /// warning that says which, or an empty text.
  std::string move_joints_into_travel(const KinematicChain& chain);
  Eigen::Vector3d position(int r) const;
  Eigen::Quaterniond orientation(int r) const;
  /// True if all cells of point and orientation are empty: the row was not measured.
  bool is_unmeasured(int r) const;
  [[noreturn]] void fail(int r, const std::string& quantity, const std::string& what) const;

  /// Times of the rows.
  struct Clock {
    bool is_number = false;
    std::vector<double> seconds;   ///< if numbers
    std::vector<PlainTime> times;  ///< otherwise
    /// The time of a row since `zero` [s]; numbers as they are, without regard to `zero`.
    double since(int r, const PlainTime& zero) const;
  };
  /// The column t_s, or date and t_s; all rows in one form.
  Clock clock() const;

 private:
  double number(int r, const MappedColumn& column) const;
  PlainTime time(int r) const;

  const PlainTable& table_;
  const ColumnMapping& mapping_;
  // Columns that each row needs; without those quantities none.
  std::vector<const MappedColumn*> position_, orientation_, joints_;
  JointRows moved_;             // if some were moved: those of the measured rows
  std::vector<int> moved_row_;  // of each row of the table; -1 where it is not measured
};

}  // namespace armtrue
