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

/// With which commands are written.
inline int command_decimals(double unit) {
  constexpr int kAngleDecimals = 9, kLengthDecimals = 7;
  if (unit == kMillimetre) return kLengthDecimals;
  if (unit == kDegree) return kAngleDecimals;
  return 11;  // m, rad
}

}  // namespace armtrue
