#include "armtrue/path/joint_reversals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

// A joint that swings by 2 deg turns back at each quarter of its period, one that trembles by 0.001
// deg on its way never, and one that stands still neither.
TEST(JointReversals, AreWhereAJointTurnsBack) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(401, 0, 4);
  JointMatrix q(3, 401);
  for (Eigen::Index i = 0; i < 401; ++i) {
    const double t = time[i];
    q.col(i) << 2 * kDegree * std::sin(std::numbers::pi * t),
        t * kDegree + 0.001 * kDegree * std::sin(50 * t), 0.3;
  }
  std::vector<double> times;
  for (const JointReversal& reversal : joint_reversals(time, q)) {
    EXPECT_EQ(reversal.joint, 0);
    times.push_back(reversal.time);
  }
  ASSERT_EQ(times.size(), 4);
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(times[k], 0.5 + static_cast<double>(k), 1e-9);
}

}  // namespace
}  // namespace armtrue
