#include <gtest/gtest.h>

#include <cmath>

#include "compensation/second_arm.h"

namespace armtrue::branch_test {
namespace {

using armtrue_oracle::Uniform;

constexpr double kMicrometre = 1e-6;

struct SmallWrist {
  Robot nominal, identified;
  std::vector<JointVector> targets;
  std::vector<CorrectedTarget> found;
};

// Targets with axis 5 within `bend` of zero, of random arms; `count` each.
std::vector<SmallWrist> small_wrists(double low, double high, unsigned seed) {
  Uniform uniform(seed);
  std::vector<SmallWrist> all;
  for (int arm = 0; arm < 20; ++arm) {
    SmallWrist& one = all.emplace_back();
    one.nominal = read_robot(kNominalArm).robot;
    one.identified = random_arm(uniform);
    for (int k = 0; k < 20; ++k) {
      JointVector q = random_target(one.nominal.chain, uniform);
      q[1] = uniform(-110, -20) * kDegree;
      q[2] = uniform(30, 120) * kDegree;  // of an arm that is bent
      q[4] = (k % 2 ? -1 : 1) * uniform(low, high);
      one.targets.push_back(q);
    }
    CompensationOptions options;
    options.tool = {rotation_from_abc(0.3, -0.8, 1.1), {0.05, -0.02, 0.21}};
    options.max_correction = 0.1;
    one.found = compensate(one.identified, one.nominal, joint_program(one.targets), options);
  }
  return all;
}

TEST(SingularWrist, IsDampedAndNamedWithinATenthOfADegree) {
  int left = 0;
  for (const SmallWrist& arm : small_wrists(0, 0.1 * kDegree, 11))
    for (size_t k = 0; k < arm.targets.size(); ++k) {
      const CorrectedTarget& target = arm.found[k];
      const JointVector change = target.q - arm.targets[k];
      EXPECT_TRUE(target.has(CommandNote::singular)) << arm.targets[k].transpose() / kDegree;
      // No joint swings, the wrist stays on its side.
      EXPECT_LT(change.cwiseAbs().maxCoeff(), 1.01 * kDegree);
      EXPECT_GE(target.q[4] * arm.targets[k][4], 0);
      left += !target.is_corrected;
      // The position is corrected nonetheless, and orientation is not worse.
      if (!target.is_corrected) continue;
      EXPECT_LT(target.after.position, 0.2 * target.before.position);
      EXPECT_LT(target.after.position, 200 * kMicrometre);
    }
  EXPECT_EQ(left, 0);
}

TEST(SingularWrist, OfExactlyZeroIsOfBothBranches) {
  for (const SmallWrist& arm : small_wrists(0, 0, 12))
    for (size_t k = 0; k < arm.targets.size(); ++k) {
      EXPECT_TRUE(arm.found[k].has(CommandNote::singular));
      EXPECT_LT((arm.found[k].q - arm.targets[k]).cwiseAbs().maxCoeff(), 1.01 * kDegree);
    }
}

TEST(SingularWrist, BentByFiveDegreesIsLeftToItself) {
  for (const SmallWrist& arm : small_wrists(5 * kDegree, 20 * kDegree, 13))
    for (const CorrectedTarget& target : arm.found) {
      EXPECT_FALSE(target.has(CommandNote::singular));
      EXPECT_LT(target.after.position, 1e-9);
    }
}

// From a bent wrist to a stretched one the correction changes without a jump.
TEST(SingularWrist, IsEnteredSmoothly) {
  Uniform uniform(14);
  const Robot nominal = read_robot(kNominalArm).robot;
  const Robot identified = random_arm(uniform);
  JointVector q(6);
  q << 0.3, -1.1, 1.3, 0.5, 0, -0.4;
  std::vector<JointVector> targets;
  for (double bend = 4; bend > 0.1; bend -= 0.02) {
    q[4] = bend * kDegree;
    targets.push_back(q);
  }
  CompensationOptions options;
  options.max_correction = 0.1;
  const auto found = compensate(identified, nominal, joint_program(targets), options);
  for (size_t k = 1; k < targets.size(); ++k) {
    const JointVector change = (found[k].q - targets[k]) - (found[k - 1].q - targets[k - 1]);
    EXPECT_LT(change.cwiseAbs().maxCoeff(), 0.2 * kDegree) << targets[k][4] / kDegree;
  }
}

}  // namespace
}  // namespace armtrue::branch_test
