#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "import/column_mapping.h"

namespace armtrue {

/// Which columns hold the orientation, and by which convention: `abc`, `rpy` (roll, pitch, yaw) or
/// `rpy-rx` (the same as rx, ry, rz), `rotvec`, `quaternion` (named w, x, y, z), `quat0-wxyz`,
/// `quat1-xyzw` and so on, `matrix` (r11 to r33); empty without orientation. Throws InputError if
/// the columns or the options leave it open.
std::string find_orientation(const PlainTable& table, const ColumnMapping& mapping,
                             const ImportOptions& options);

/// The quantities that this orientation is read from, in the order that orientation() takes.
std::vector<std::string> orientation_quantities(const std::string& orientation);

/// The numbers of one orientation, at most those of a matrix, row by row.
using OrientationNumbers = std::array<double, 9>;

/// The rotation of the numbers [rad or 1]. A quaternion that is not of unit length and a matrix
/// that is no rotation, within 1e-3, give nothing.
std::optional<Eigen::Quaterniond> orientation_of(const std::string& orientation,
                                                 const OrientationNumbers& n);

}  // namespace armtrue
