#include "armtrue/path/path.h"

namespace armtrue {
namespace {

constexpr double kStandstill = 1e-9;  // [m] between neighbours: rounding, no motion

}  // namespace

Eigen::VectorXd arc_length(const Path& path) {
  Eigen::VectorXd length = Eigen::VectorXd::Zero(path.samples());
  for (Eigen::Index i = 1; i < path.samples(); ++i)
    length[i] = length[i - 1] + (path.position.col(i) - path.position.col(i - 1)).norm();
  return length;
}

Eigen::Matrix3Xd tangents(const Path& path) {
  const Eigen::Index n = path.samples();
  Eigen::Matrix3Xd tangent = Eigen::Matrix3Xd::Zero(3, n);
  Eigen::VectorXd from_last = Eigen::VectorXd::Constant(n, -1);  // samples since the last motion
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d chord = path.position.col(std::min(i + 1, n - 1)) -
                                  path.position.col(std::max<Eigen::Index>(i - 1, 0));
    if (chord.norm() > kStandstill) {
      tangent.col(i) = chord.normalized();
      from_last[i] = 0;
    } else if (i > 0 && from_last[i - 1] >= 0) {
      tangent.col(i) = tangent.col(i - 1);
      from_last[i] = from_last[i - 1] + 1;
    }
  }
  // From behind: standstill takes the motion to come if that is nearer.
  double to_next = -1;
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    if (from_last[i] == 0)
      to_next = 0;
    else if (to_next >= 0 && (++to_next < from_last[i] || from_last[i] < 0))
      tangent.col(i) = tangent.col(i + 1);
  }
  return tangent;
}

}  // namespace armtrue
