#pragma once

namespace armtrue::app {

// The columns of each kind of CSV file, for --help; see Command::add_columns(). Decimal commas,
// other units and missing rows are in armtrue-formats(5).

inline constexpr const char* kMeasuredPoseColumns =
    "Columns of measured poses, one row per reading:\n"
    "  pose, q1_deg..q6_deg; x_mm, y_mm, z_mm or the distance l_mm to the point named in anchor\n"
    "  instead of them: contact, the name of what the tool touches, and l_mm, a gauge's reading "
    "there\n"
    "  optional orientation: a_deg, b_deg, c_deg (R = Rz(a) Ry(b) Rx(c)) or qw, qx, qy, qz\n"
    "  optional: repeat, t_s, session, target, sigma_mm, sigma_deg, or covariances cov_xx_mm2 ...\n"
    "  optional causes of effects: payload_kg, temp_NAME_c, fx_n, fy_n, fz_n, dir1..dir6,\n"
    "  stroke1_deg..stroke6_deg, tau1_nm..tau6_nm\n";

inline constexpr const char* kPathColumns =
    "Columns of paths and passes, one row per sample:\n"
    "  t_s, x_mm, y_mm, z_mm; a measured pass may leave x_mm, y_mm, z_mm empty (lost sample)\n"
    "  optional: a_deg, b_deg, c_deg (R = Rz(a) Ry(b) Rx(c)); q1_deg..q6_deg; fx_n, fy_n, fz_n\n";

inline constexpr const char* kJointTargetColumns =
    "Columns of targets, one row per pose:\n"
    "  pose, q1_deg..q6_deg\n";

inline constexpr const char* kProgramColumns =
    "Columns of targets, one row per target:\n"
    "  pose; q1_deg..q6_deg, or x_mm, y_mm, z_mm, a_deg, b_deg, c_deg (R = Rz(a) Ry(b) Rx(c)) and\n"
    "  q1_deg..q6_deg as a hint of the branch; optional: t (KUKA's turn)\n"
    "  optional causes of effects: payload_kg, t_s, temp_NAME_c, fx_n, fy_n, fz_n, dir1..dir6,\n"
    "  stroke1_deg..stroke6_deg\n";

}  // namespace armtrue::app
