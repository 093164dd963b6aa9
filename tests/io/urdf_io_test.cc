#include "armtrue/io/urdf_io.h"

#include <gtest/gtest.h>

#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

void expect_same_arm(const Robot& a, const Robot& b) {
  for (const JointVector& q : sample_joint_space(a.chain, 20)) {
    const Pose left = ChainEvaluator(a.chain).pose(q), right = ChainEvaluator(b.chain).pose(q);
    EXPECT_LT((left.translation - right.translation).norm(), 1e-9);
    EXPECT_LT((left.rotation - right.rotation).norm(), 1e-9);
  }
}

TEST(Urdf, ComesBackToTheLastDigit) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-table4.yaml").robot;
  robot.chain.links[2].sign = -1;
  robot.noise = {};
  const Robot back = parse_urdf(write_urdf(robot), "r.urdf");
  for (int j = 0; j < kLinks; ++j) {
    EXPECT_EQ(back.chain.links[j].alpha, robot.chain.links[j].alpha);
    EXPECT_EQ(back.chain.links[j].d, robot.chain.links[j].d);
    EXPECT_EQ(back.chain.links[j].theta, robot.chain.links[j].theta);
    EXPECT_EQ(back.chain.links[j].r, robot.chain.links[j].r);
    EXPECT_EQ(back.chain.links[j].beta, robot.chain.links[j].beta);
    EXPECT_EQ(back.chain.links[j].min, robot.chain.links[j].min);
    EXPECT_EQ(back.chain.links[j].name, robot.chain.links[j].name);
  }
  EXPECT_EQ(write_robot(back), write_robot(robot));
}

TEST(Urdf, NamesMayHoldWhatXmlReserves) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  const std::string name = "KR 360 & <spindle> \"b\" 'c' &amp; &#x41;";
  robot.name = name;
  for (Link& link : robot.chain.links) link.name += name;
  const Robot back = parse_urdf(write_urdf(robot), "r.urdf");
  EXPECT_EQ(back.name, name);
  for (int j = 0; j < kLinks; ++j) {
    EXPECT_EQ(back.chain.links[j].name, robot.chain.links[j].name);
    EXPECT_EQ(back.chain.links[j].theta,
              robot.chain.links[j].theta);  // the exact entries are found
  }
}

// Somebody else's URDF has no attributes of ours: the frames follow from the axes.
TEST(Urdf, AForeignDescriptionIsTheSameArm) {
  for (const char* name : {"kr360", "kr360-eq1-zero", "kr360-spindle"}) {
    const Robot robot = read_robot(std::string(ARMTRUE_CONFIG "/robots/") + name + ".yaml").robot;
    std::string text = write_urdf(robot);
    for (size_t begin; (begin = text.find("    <armtrue")) != std::string::npos;)
      text.erase(begin, text.find("/>\n", begin) + 3 - begin);
    expect_same_arm(robot, parse_urdf(text, name));
  }
}

TEST(Urdf, AChangedOriginCounts) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  std::string text = write_urdf(robot);
  const size_t place = text.find("xyz=\"0.5 ");
  ASSERT_NE(place, std::string::npos);
  text.replace(place, 9, "xyz=\"0.6 ");
  EXPECT_NEAR(parse_urdf(text, "r").chain.links[1].d, 0.6, 1e-12);
}

TEST(Urdf, WhatIsNoArmIsAnError) {
  EXPECT_THROW(parse_urdf("<robot", "r"), InputError);
  EXPECT_THROW(parse_urdf("<robot name=\"x\"><link name=\"a\"/></robot>", "r"), InputError);
}

}  // namespace
}  // namespace armtrue
