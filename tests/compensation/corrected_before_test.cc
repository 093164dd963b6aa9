// Which numbers speak for targets that were corrected before, and which are short for a reason of
// their own.

#include "armtrue/compensation/corrected_before.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compensation/second_arm.h"

namespace armtrue::corrected_before_test {
namespace {

using armtrue_oracle::Uniform;

constexpr double kFourDecimals = 1e-4 * kDegree;

// An arm whose elbow is stretched at 0 deg.
Robot controller() { return read_robot(ARMTRUE_CONFIG "/robots/ur10e.yaml").robot; }

JointVector any_joints(Uniform& uniform) {
  JointVector q(6);
  for (int j = 0; j < 6; ++j)
    q[j] = std::round(uniform(-1.5, 1.5) / kFourDecimals) * kFourDecimals;
  return q;
}

// The same numbers a little elsewhere, with all their digits.
JointVector beside(const JointVector& q, Uniform& uniform) {
  JointVector moved = q;
  for (double& angle : moved) angle += uniform(-2e-3, 2e-3);
  return moved;
}

std::vector<CorrectedTarget> any_targets(int count, Uniform& uniform) {
  std::vector<CorrectedTarget> targets(static_cast<size_t>(count));
  for (CorrectedTarget& target : targets) {
    target.programmed = any_joints(uniform);
    target.reached_q = beside(target.programmed, uniform);
  }
  return targets;
}

// Near a stretched elbow a longer arm reaches where the controller's model does not: the angle that
// comes nearest is that of the stretched arm, and says nothing about the target.
TEST(CorrectedBefore, APoseThatTheControllerDoesNotHaveSaysNothing) {
  Uniform uniform(3);
  Robot longer = controller();
  longer.chain.links[3].d -= 3e-3;
  std::vector<JointVector> q;
  for (int k = 0; k < 60; ++k) {
    q.push_back(any_joints(uniform));
    q.back()[2] = k < 12 ? std::round(uniform(0.02, 0.08) / kFourDecimals) * kFourDecimals : 1.3;
    q.back()[4] = std::round(uniform(0.5, 1.5) / kFourDecimals) * kFourDecimals;
  }
  const std::vector<CorrectedTarget> targets =
      compensate(longer, controller(), joint_program(q), {});
  for (size_t k = 0; k < 12; ++k) EXPECT_EQ(targets[k].reached_q, q[k]) << k;
  for (size_t k = 12; k < 60; ++k) EXPECT_NE(targets[k].reached_q, q[k]) << k;
  EXPECT_FALSE(find_round_where_reached(controller(), targets));
}

// A singular posture, or a limit, gives one joint the same angle at many targets.
TEST(CorrectedBefore, ANumberThatComesAgainCountsOnce) {
  Uniform uniform(5);
  std::vector<CorrectedTarget> targets = any_targets(60, uniform);
  for (size_t k = 0; k < 40; ++k) targets[k].reached_q[2] = 0;
  EXPECT_FALSE(find_round_where_reached(controller(), targets));
}

// Some joints stand at right angles for reasons of their own.
TEST(CorrectedBefore, AFewShortNumbersMayBeChance) {
  Uniform uniform(7);
  std::vector<CorrectedTarget> targets = any_targets(60, uniform);
  for (size_t j = 0; j < 6; ++j) targets[10 * j].reached_q[static_cast<Eigen::Index>(j)] = 0;
  EXPECT_FALSE(find_round_where_reached(controller(), targets));
}

// Whole degrees come back where commands that were corrected are corrected once more, whatever else
// is among them.
TEST(CorrectedBefore, CommandsOfShortTargetsAreKnown) {
  Uniform uniform(9);
  Robot identified = random_arm(uniform);
  const Robot nominal = read_robot(kNominalArm).robot;
  for (const int corrected : {2, 4, 20}) {
    std::vector<JointVector> q;
    for (int k = 0; k < corrected; ++k) {
      q.push_back(random_target(nominal.chain, uniform) / kDegree);
      for (double& angle : q.back()) angle = std::round(angle) * kDegree;
    }
    CompensationOptions options;
    options.max_correction = 1;
    std::vector<JointVector> commands;
    for (const CorrectedTarget& target :
         compensate(identified, nominal, joint_program(q), options))
      commands.push_back(target.q);
    for (int k = 0; k < corrected; ++k)
      commands.push_back(random_target(nominal.chain, uniform));  // with all its digits
    const auto found = find_round_where_reached(
        nominal, compensate(identified, nominal, joint_program(commands), options));
    ASSERT_TRUE(found) << corrected;
    EXPECT_GE(found->round, 5 * corrected);
  }
}

}  // namespace
}  // namespace armtrue::corrected_before_test
