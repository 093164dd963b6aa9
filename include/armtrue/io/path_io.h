#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/io/quantity_column.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/path/path.h"
#include "armtrue/statistics/check_digits.h"

namespace armtrue {

struct PathFile {
  std::string source;  ///< for messages
  Path path;
  std::vector<int> line;  ///< of each sample
  int lost = 0;           ///< rows whose position is empty; they are no samples
  std::string sha256;
  /// The corrector whose check digits it has: those of write_path_like() (mirror), or of
  /// write_commands().
  std::optional<Corrector> corrected_by;
  std::vector<std::string> unknown_columns;  ///< not used; the command warns of them
  std::array<QuantityColumn, 3> position{};  ///< columns of x, y and z
  /// The file as it was read, for write_path_like(): column names, and the cells of the rows.
  std::vector<std::string> columns;
  std::string rows;
};

/// Whether read_path() keeps the text of the rows, for write_path_like().
enum class KeepRows { no, yes };

/// Reads `t_s,x_mm,y_mm,z_mm` and, if present, `a_deg,b_deg,c_deg`, `q1_deg..q6_deg` and
/// `fx_n,fy_n,fz_n`. Rows with an empty position are lost samples. Throws InputError for a missing
/// or malformed column, time that does not increase, or an incomplete group of orientation, joints
/// or force; with KeepRows::yes also for a lost sample.
PathFile read_path(const std::string& file, KeepRows keep = KeepRows::no,
                   const std::vector<JointName>& joints = six_axis_names());

/// Reads `t_s,fx_n,fy_n,fz_n`, the record of a force plate: a path without positions. Other columns
/// are not used. Throws InputError as read_path() does.
PathFile read_force_record(const std::string& file);

/// The columns of read_path() that the path has, as text, rounded to 0.1 us, a nanometre, a
/// nanodegree and a micronewton.
std::string write_path(const Path& path, const std::vector<JointName>& joints = six_axis_names());

/// The rows of `file` (read with KeepRows::yes) with other positions; every other column, and a
/// position that did not move by half a nanometre, stays as it was read. New positions are rounded
/// to a nanometre and have two more digits, the check digits. They move by up to 1.2 um, so that
/// they are recognised after rounding to a micrometre.
std::string write_path_like(const PathFile& file, const Eigen::Matrix3Xd& position);

}  // namespace armtrue
