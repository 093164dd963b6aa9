#include "armtrue/io/covariance_column.h"

#include <array>

#include "armtrue/kinematics/units.h"

namespace armtrue {

std::string covariance_column(int row, int column, bool si) {
  constexpr std::array kNames{"x", "y", "z", "rx", "ry", "rz"};
  const std::string unit = row >= 3      ? (si ? "_rad2" : "_deg2")
                           : column >= 3 ? (si ? "_m_rad" : "_mm_deg")
                                         : (si ? "_m2" : "_mm2");
  return std::string("cov_") + kNames[row] + kNames[column] + unit;
}

double covariance_unit(int row, int column) {
  return (row >= 3 ? kDegree : kMillimetre) * (column >= 3 ? kDegree : kMillimetre);
}

}  // namespace armtrue
