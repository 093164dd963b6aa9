#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace armtrue {

/// encoder: the value of a joint, an angle or a length according to its unit.
enum class UnitKind { none, length, angle, encoder, time, mass, temperature, force };

struct ColumnUnit {
  UnitKind kind = UnitKind::none;
  double factor = 1;  ///< to m, rad, s, kg, deg C or N
};

/// mm, m, in, deg, °, rad, ms, ...; capital letters do not count. Nothing if it is no unit.
std::optional<ColumnUnit> find_unit(std::string_view text);

/// The name of a column, apart from the unit that it states: `X [mm]`, `x_mm`, `A1 / rad`.
struct ColumnName {
  std::string stem;  ///< X
  std::string unit;  ///< mm; empty if none is stated
};
ColumnName column_name(std::string_view header);

/// What armtrue calls a quantity: pose, repeat, session, target, t, date, q1 to q16, e1 to e6, x,
/// y, z, a, b, c, roll, pitch, yaw, rx, ry, rz, qw, qx, qy, qz, quat0 to quat4 (a quaternion whose
/// order the names do not tell), fx, fy, fz, payload, temp_<where>, image (the file of a row).
/// Presets also know cov0 to cov35, the entries of a covariance, row by row.
struct KnownQuantity {
  std::string name;
  UnitKind kind = UnitKind::none;
};

/// The name and the unit of a header such as `A1 [Grad]`, whose name is known and whose unit is
/// not.
std::optional<ColumnName> unknown_unit(std::string_view header);

/// The quantity that a column of this header holds, by its name alone.
std::optional<KnownQuantity> known_quantity(std::string_view header);

/// A quantity as the user writes it before = of --column: q1_deg or q1.
std::optional<KnownQuantity> stated_quantity(std::string_view ours);

/// The number of a joint, q1 to q16 or the external axes e1 to e6; 0 for any other quantity.
int joint_number(std::string_view quantity);

/// Whether a column of a quantity may have this unit.
bool fits_kind(UnitKind quantity, UnitKind unit);

/// Name of the quantity as a column of measured poses: q1_deg, e1_mm, x_mm, t_s.
std::string our_column(const std::string& quantity);

/// True of a column that may hold an angle or a part of an orientation.
bool looks_like_angle(std::string_view header, std::string_view unit);

}  // namespace armtrue
