#include "armtrue/kinematics/inverse.h"

#include <gtest/gtest.h>

#include <numbers>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "kinematics/six_axes.h"
#include "support/oracle.h"
#include "support/random_chain.h"

namespace armtrue::inverse_test {
namespace {

using armtrue_oracle::Uniform;

const std::string kArm = ARMTRUE_CONFIG "/robots/kr360-table4.yaml";

JointVector within_travel(const KinematicChain& chain, Uniform& uniform) {
  JointVector q(6);
  for (int j = 0; j < kJoints; ++j)
    q[j] =
        uniform(chain.links[static_cast<size_t>(j)].min, chain.links[static_cast<size_t>(j)].max);
  return q;
}

TEST(Inverse, ComesBackToTheAnglesOfTheOraclesPose) {
  const KinematicChain chain = read_robot(kArm).robot.chain;
  const armtrue_oracle::OracleArm arm = armtrue_oracle::read_arm(kArm);
  Uniform uniform(3);
  int singular = 0;
  for (int i = 0; i < 500; ++i) {
    const JointVector q = within_travel(chain, uniform);
    const KDL::Frame frame = armtrue_oracle::forward(arm, {q[0], q[1], q[2], q[3], q[4], q[5]});
    Pose pose;
    for (int row = 0; row < 3; ++row) {
      pose.translation[row] = frame.p[row];
      for (int column = 0; column < 3; ++column) pose.rotation(row, column) = frame.M(row, column);
    }
    JointVector start = q;
    for (int j = 0; j < kJoints; ++j) start[j] += uniform(-0.02, 0.02);
    const InverseResult found = inverse_kinematics(chain, pose, start);
    ASSERT_TRUE(found.reached) << q.transpose() / kDegree;
    EXPECT_LT((ChainEvaluator(chain).pose(found.q).translation - pose.translation).norm(), 1e-9);
    // Within some degrees of a singular pose another branch may be as near.
    if ((found.q - q).norm() > 1e-6) ++singular;
  }
  EXPECT_LT(singular, 25);
}

TEST(Inverse, AStretchedWristIsNoObstacle) {
  const KinematicChain chain = read_robot(kArm).robot.chain;
  JointVector q(6);
  q << 0.1, -1.2, 1.9, 0.3, 0, 0.2;
  const Pose pose = ChainEvaluator(chain).pose(q);
  for (double off : {-0.01, 0.0, 0.01}) {
    JointVector start = q;
    start[4] += off;
    EXPECT_TRUE(inverse_kinematics(chain, pose, start).reached) << off;
  }
}

TEST(Inverse, WhatIsOutOfReachIsLeftWithItsDistance) {
  const KinematicChain chain = read_robot(kArm).robot.chain;
  JointVector q(6);
  q << 0.1, -1.2, 1.9, 0.3, 0.5, 0.2;
  Pose pose = ChainEvaluator(chain).pose(q);
  pose.translation.x() += 10;
  const InverseResult found = inverse_kinematics(chain, pose, q);
  EXPECT_FALSE(found.reached);
  EXPECT_GT(found.position_error, 5);
}

TEST(Inverse, FromSeveralStartsTheSolutionNearestToTheMiddleOfTheTravel) {
  const KinematicChain chain = read_robot(kArm).robot.chain;
  Uniform uniform(5);
  JointVector middle(6);
  middle << 0, -0.96, 0.38, 0.2, 0.6, -0.3;
  const Pose pose = ChainEvaluator(chain).pose(middle);
  std::vector<JointVector> starts;
  for (int i = 0; i < 64; ++i) starts.push_back(within_travel(chain, uniform));
  const auto q = inverse_kinematics(chain, pose, starts);
  ASSERT_TRUE(q);
  EXPECT_FALSE(beyond_travel(chain, *q));
  EXPECT_LT((*q - middle).norm(), 1e-6);
  KinematicChain narrow = chain;
  narrow.links[1].min = narrow.links[1].max = 0;
  EXPECT_FALSE(inverse_kinematics(narrow, pose, starts));
}

// Joint 6 follows half the motion of joint 1: a whole turn of joint 1 is half of one of joint 6.
TEST(Inverse, TurnsThatOthersFollowInPartReachThePoseToo) {
  KinematicChain chain = read_robot(kArm).robot.chain;
  for (Link& link : chain.links) link.min = -(link.max = 2 * std::numbers::pi);
  chain.couplings.push_back({.follower = 5, .followed = 0, .coefficient = 0.5});
  JointVector turned(6);
  turned << 0.3, -1.0, 1.5, 0.4, 0.7, 0.2;
  const Pose wanted = ChainEvaluator(chain).pose(turned);
  turned[0] += 2 * std::numbers::pi;
  turned[5] -= std::numbers::pi;
  const auto q = inverse_kinematics(chain, wanted, std::vector{turned});
  ASSERT_TRUE(q);
  const Pose reached = ChainEvaluator(chain).pose(*q);
  EXPECT_LT((reached.translation - wanted.translation).norm(), 1e-9);
  EXPECT_LT(rotation_log(reached.rotation.transpose() * wanted.rotation).norm(), 1e-9);
}

}  // namespace
}  // namespace armtrue::inverse_test
