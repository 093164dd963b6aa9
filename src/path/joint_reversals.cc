#include "armtrue/path/joint_reversals.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"

namespace armtrue {

std::vector<JointReversal> joint_reversals(const Eigen::VectorXd& time, const JointMatrix& q) {
  constexpr double kMinReversal = 0.01 * kDegree;  // travel that shows a direction
  std::vector<JointReversal> reversals;
  for (Eigen::Index joint = 0; joint < q.rows(); ++joint) {
    Eigen::Index furthest = 0;  // sample, in this direction
    int direction = 0;
    for (Eigen::Index i = 1; i < q.cols(); ++i) {
      const double moved = q(joint, i) - q(joint, furthest);
      const bool goes_on = direction * moved > 0;
      if (!goes_on && std::abs(moved) < kMinReversal) continue;
      if (!goes_on) {
        if (direction != 0) reversals.push_back({time[furthest], static_cast<int>(joint)});
        direction = moved > 0 ? 1 : -1;
      }
      furthest = i;
    }
  }
  std::ranges::stable_sort(reversals, {}, &JointReversal::time);
  return reversals;
}

}  // namespace armtrue
