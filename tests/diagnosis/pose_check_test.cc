#include "armtrue/diagnosis/pose_check.h"

#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/units.h"
#include "kinematics/six_axes.h"

namespace armtrue::pose_check_test {
namespace {

const JointVector kBent = (JointVector(6) << 0.3, -1.2, 1.4, 0.5, 0.7, -0.9).finished();

// KDL's DH frames are of the standard convention.
TEST(Conventions, AStandardTableIsTheArmOfKdl) {
  KinematicChain rows;
  rows.links = six_axis_links();
  KDL::Chain chain;
  for (int j = 0; j < kLinks; ++j) {
    Link& link = rows.links[static_cast<size_t>(j)];
    link.alpha = 0.3 + 0.4 * j;
    link.d = 0.5 - 0.1 * j;
    link.theta = 0.2 * j - 0.6;
    link.r = 0.05 + 0.07 * j;
    chain.addSegment(
        KDL::Segment(j < kJoints ? KDL::Joint(KDL::Joint::RotZ) : KDL::Joint(KDL::Joint::Fixed),
                     KDL::Frame::DH(link.d, link.alpha, link.r, link.theta)));
  }
  rows.tool.translation = {0.1, 0.2, 0.3};
  KDL::JntArray q(kJoints);
  for (unsigned j = 0; j < kJoints; ++j) q(j) = kBent[j];
  KDL::Frame flange;
  KDL::ChainFkSolverPos_recursive(chain).JntToCart(q, flange);
  const KDL::Vector tool = flange * KDL::Vector(0.1, 0.2, 0.3);
  const Pose pose = ChainEvaluator(from_standard(rows)).pose(kBent);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(pose.translation[i], tool(i), 1e-12);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(pose.rotation(i, k), flange.M(i, k), 1e-12);
  }
}

TEST(Conventions, BetaIsNoStandardParameter) {
  KinematicChain rows;
  rows.links = six_axis_links();
  rows.links[2].beta = 0.1;
  EXPECT_THROW(from_standard(rows), std::invalid_argument);
}

PendantPose flange_of(const Robot& robot) {
  const Pose flange = shown_frames(robot, kBent).front().pose;
  const Eigen::Vector3d t = flange.translation / kMillimetre;
  const Eigen::Vector3d abc = abc_from_rotation(flange.rotation) / kDegree;
  return {t.x(), t.y(), t.z(), abc[0], abc[1], abc[2]};
}

struct PoseCheck : testing::Test {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/ur5e.yaml").robot;
  std::vector<Agreement> find(const PendantPose& pose, const Robot& typed) const {
    return find_agreements(typed, kBent, pose, 1e-3, 1e-3);
  }
};

TEST_F(PoseCheck, WhatAgreesNeedsNoChange) {
  const auto found = find(flange_of(robot), robot);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(found.front().changes.empty());
  EXPECT_LT(found.front().distance, 1e-9);
}

TEST_F(PoseCheck, EachMistakeIsNamed) {
  for (size_t j = 0; j < kJoints; ++j) {
    Robot typed = robot;
    typed.chain.links[j].sign = -1;
    const auto found = find(flange_of(robot), typed);
    ASSERT_FALSE(found.empty()) << j;
    EXPECT_NE(found.front().changes.front().find("counts the other way"), std::string::npos);
    Robot zero = robot;
    zero.chain.links[j].theta -= 90 * kDegree;
    const auto other = find(flange_of(robot), zero);
    ASSERT_FALSE(other.empty()) << j;
    EXPECT_LT(other.front().distance, 1e-9);
    EXPECT_EQ(other.front().changes.size(), 1u);
  }
  PendantPose in_metres = flange_of(robot);
  for (size_t i = 0; i < 3; ++i) in_metres[i] /= 1000;
  EXPECT_EQ(find(in_metres, robot).front().changes.front(), "the place of the pose is in m");
}

TEST_F(PoseCheck, TwoMistakesAreNamed) {
  Robot typed = robot;
  typed.chain.links[3].sign = -1;
  PendantPose wpr = flange_of(robot);
  std::swap(wpr[3], wpr[5]);
  const auto found = find(wpr, typed);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().changes.size(), 2u);
  EXPECT_LT(found.front().distance, 1e-9);
}

TEST_F(PoseCheck, ForeignLengthsAreNotExplainedAway) {
  Robot longer = robot;
  longer.chain.links[2].d += 0.05;
  EXPECT_TRUE(find(flange_of(robot), longer).empty());
}

}  // namespace
}  // namespace armtrue::pose_check_test
