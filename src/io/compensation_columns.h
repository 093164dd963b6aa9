#pragma once

#include <array>
#include <string>

#include "armtrue/kinematics/units.h"

namespace armtrue {

/// Columns that compensate adds to a program; those of commands are not among them.
inline const std::array<std::string, 7> kCommandColumns{"predicted_before_mm",
                                                        "predicted_before_mrad",
                                                        "predicted_after_mm",
                                                        "predicted_after_mrad",
                                                        "std_mm",
                                                        "leverage",
                                                        "note"};

inline const std::array<std::string, 6> kPoseColumns{"x_mm",  "y_mm",  "z_mm",
                                                     "a_deg", "b_deg", "c_deg"};

/// Decimals of a command: 7 in mm, 9 in deg, 10 in m and rad. A corrected one has two check digits
/// more, which are the same in m and in mm.
inline int command_decimals(double unit) {
  return unit == kMillimetre ? 7 : unit == kDegree ? 9 : 10;
}
inline constexpr int kCheckDecimals = 2;

}  // namespace armtrue
