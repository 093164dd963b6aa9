#include "armtrue/urdf/urdf_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml.h>

#include <Eigen/Geometry>
#include <cmath>
#include <kdl/frames.hpp>
#include <limits>
#include <map>
#include <regex>
#include <sstream>

#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/text/input_error.h"
#include "kinematics/six_axes.h"
#include "urdf_kinematics.h"

namespace armtrue::urdf_io_test {
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

// The positions of all joints, by the rule of a mimic: multiplier * position + offset.
std::vector<double> positions(const oracle::UrdfArm& arm, const std::string& text,
                              const JointVector& q) {
  TiXmlDocument document;
  document.Parse(text.c_str());
  std::map<std::string, const TiXmlElement*> mimics;
  const TiXmlElement* const root = document.RootElement();
  for (auto joint = root->FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint"))
    mimics[joint->Attribute("name")] = joint->FirstChildElement("mimic");
  std::map<std::string, double> position;
  int driven = 0;
  for (const oracle::UrdfJoint& joint : arm.joints())
    if (joint.is_driven && !mimics.at(joint.name)) position[joint.name] = q[driven++];
  std::vector<double> all;
  for (const oracle::UrdfJoint& joint : arm.joints()) {
    if (!joint.is_driven) continue;
    if (const TiXmlElement* const mimic = mimics.at(joint.name))
      position[joint.name] =
          std::stod(mimic->Attribute("multiplier")) * position.at(mimic->Attribute("joint")) +
          std::stod(mimic->Attribute("offset"));
    all.push_back(position.at(joint.name));
  }
  return all;
}

void expect_arm_of(const Robot& robot, const std::string& text, const std::string& name) {
  const oracle::UrdfArm arm(text, "world", "tool");
  for (const JointVector& q : sample_joint_space(robot.chain, 40)) {
    const KDL::Frame expected = arm.pose(positions(arm, text, q));
    const Pose pose = ChainEvaluator(robot.chain).pose(q);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(pose.translation[row], expected.p(row), 1e-9) << name;
      for (int column = 0; column < 3; ++column)
        EXPECT_NEAR(pose.rotation(row, column), expected.M(row, column), 1e-9) << name;
    }
  }
}

// A tilt that follows a joint which itself is coupled, as in a palletiser with motors on its frame.
TEST(Urdf, CoupledJointsStandForOtherReadersWhereTheyStandForUs) {
  for (const std::string name : {"irb460", "kr700-pa", "m410ib-700"}) {
    Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
    ASSERT_FALSE(robot.chain.couplings.empty());
    for (Coupling& coupling : robot.chain.couplings) {
      coupling.coefficient *= 1.01;
      coupling.from += 0.02;
    }
    const std::string text = write_urdf(robot);
    expect_arm_of(robot, text, name);
    EXPECT_EQ(write_robot(parse_urdf(text, "r.urdf")), [&] {
      robot.noise = {};
      return write_robot(robot);
    }()) << name;
  }
}

TEST(Urdf, AMimicThatSomebodyChangedCounts) {
  const std::string text = write_urdf(read_robot(ARMTRUE_CONFIG "/robots/irb460.yaml").robot);
  const std::string mimic = "multiplier=\"-1\" offset=\"0\"";
  for (const std::string changed :
       {"multiplier=\"-1\" offset=\"0.1\"", "multiplier=\"-0.9\" offset=\"0\""}) {
    std::string other = text;
    other.replace(other.find(mimic), mimic.size(), changed);
    expect_arm_of(parse_urdf(other, "r.urdf"), other, changed);
  }
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

// An arm with branches, in the structure of the makers' descriptions. Its axes 2 to 4 are parallel
// but for what rounding and a calibration leave.
constexpr const char* kBranched = R"(<?xml version="1.0"?>
<robot name="cobot">
  <link name="world"/><link name="base_link"/><link name="foot"/><link name="l1"/><link name="l2"/>
  <link name="l3"/><link name="l4"/><link name="l5"/><link name="l6"/>
  <link name="base"/><link name="flange"/><link name="tool0"/><link name="sensor"/>
  <joint name="mount" type="fixed"><origin xyz="0 0 0.7"/><parent link="world"/><child link="base_link"/></joint>
  <joint name="turned" type="fixed"><origin rpy="0 0 3.141592653589793"/><parent link="base_link"/><child link="foot"/></joint>
  <joint name="j1" type="revolute"><!-- <origin xyz="9 9 9"/> -->
    <origin rpy="0 0 0" xyz="0 0 0.1625"/><parent link="foot"/><child link="l1"/>
    <axis xyz="0 0 1"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>
  <joint name="j2" type="revolute"><origin xyz='0 0 0' rpy='1.570796327 0 0'/><parent link="l1"/><child link="l2"/>
    <axis xyz="0 0 1"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>
  <joint name="j3" type="revolute"><origin rpy="0.0004 -0.0003 0.001" xyz="-0.425 0 0"/><parent link="l2"/><child link="l3"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="j4" type="continuous"><origin xyz="-0.3922 0 0.1333"/><parent link="l3"/><child link="l4"/><axis xyz="0 0 2"/></joint>
  <joint name="j5" type="revolute"><parent link="l4"/><child link="l5"/><origin rpy="1.5708 0 0" xyz="0 -0.0997 0"/>
    <axis xyz="0 0 -1"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>
  <joint name="j6" type="revolute"><parent link="l5"/><child link="l6"/><origin rpy="1.5708 3.14159 3.14159" xyz="0 0.0996 0"/>
    <axis xyz="0 0 1"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>
  <joint name="controller" type="fixed"><origin rpy="0 0 3.14159"/><parent link="base_link"/><child link="base"/></joint>
  <joint name="to_flange" type="fixed"><parent link="l6"/><child link="flange"/><origin rpy="0 -1.5708 -1.5708"/></joint>
  <joint name="to_tool" type="fixed"><parent link="flange"/><child link="tool0"/></joint>
  <joint name="to_sensor" type="fixed"><parent link="l6"/><child link="sensor"/></joint>
  <transmission name="t"><joint name="j1"><origin/></joint></transmission>
</robot>
)";
const UrdfEnds kToTool{"base_link", "tool0"};

// Forward kinematics by KDL of a document that kBranched became, from base_link to tool0.
Pose by_kdl(const std::string& text, const JointVector& q) {
  TiXmlDocument document;
  document.Parse(text.c_str());
  std::map<std::string, const TiXmlElement*> joints;
  for (const TiXmlElement* joint = document.RootElement()->FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint"))
    joints[joint->Attribute("name")] = joint;
  const auto numbers = [](const TiXmlElement* element, const char* key) {
    KDL::Vector v;
    if (element && element->Attribute(key))
      std::istringstream(element->Attribute(key)) >> v(0) >> v(1) >> v(2);
    return v;
  };
  KDL::Frame frame;
  int driven = 0;
  for (const char* name : {"turned", "j1", "j2", "j3", "j4", "j5", "j6", "to_flange", "to_tool"}) {
    const TiXmlElement* const origin = joints[name]->FirstChildElement("origin");
    const KDL::Vector xyz = numbers(origin, "xyz"), rpy = numbers(origin, "rpy");
    frame = frame * KDL::Frame(KDL::Rotation::RPY(rpy(0), rpy(1), rpy(2)), xyz);
    if (name[0] != 'j') continue;
    const KDL::Vector axis = numbers(joints[name]->FirstChildElement("axis"), "xyz");
    frame = frame * KDL::Frame(KDL::Rotation::Rot(axis, q[driven++]));
  }
  Pose pose;
  for (int row = 0; row < 3; ++row) {
    pose.translation[row] = frame.p(row);
    for (int column = 0; column < 3; ++column) pose.rotation(row, column) = frame.M(row, column);
  }
  return pose;
}

void expect_same_as_kdl(const Robot& robot, const std::string& text) {
  for (const JointVector& q : sample_joint_space(robot.chain, 40)) {
    const Pose expected = by_kdl(text, q), pose = ChainEvaluator(robot.chain).pose(q);
    EXPECT_LT((pose.translation - expected.translation).norm(), 1e-9);
    EXPECT_LT((pose.rotation - expected.rotation).norm(), 1e-9);
  }
}

TEST(Urdf, BranchesWithoutDrivenJointsAreIgnored) {
  const Robot robot = parse_urdf(kBranched, "r.urdf", kToTool);
  expect_same_as_kdl(robot, kBranched);
  EXPECT_EQ(robot.name, "cobot");
  EXPECT_EQ(robot.chain.links[3].max, std::numeric_limits<double>::infinity());
  EXPECT_EQ(frames_beside_base(kBranched, "r.urdf", kToTool), std::vector<std::string>{"base"});
}

TEST(Urdf, LinksThatStandElsewhereThanTheBaseAreNamed) {
  const UrdfEnds from_world{"world", "tool0"};
  EXPECT_EQ(frames_beside_base(kBranched, "r.urdf", from_world),
            (std::vector<std::string>{"base", "base_link"}));
  std::string text = kBranched;
  text.replace(text.find("0 0 0.7"), 7, "0 0 0.0");
  EXPECT_EQ(frames_beside_base(text, "r.urdf", from_world), std::vector<std::string>{"base"});
  text.erase(text.find("  <joint name=\"controller\""),
             text.find("  <joint name=\"to_flange\"") - text.find("  <joint name=\"controller\""));
  text.erase(text.find("<link name=\"base\"/>"), 19);
  EXPECT_EQ(frames_beside_base(text, "r.urdf", from_world), std::vector<std::string>{"foot"});
}

TEST(Urdf, WhatItCannotHoldIsNamed) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  const std::vector<std::string> without = lost_in_urdf(robot);
  robot.noise = {};
  EXPECT_THAT(lost_in_urdf(robot), testing::Not(testing::Contains("noise")));
  robot.noise.pixel = 0.1;
  EXPECT_EQ(lost_in_urdf(robot), without);
  robot.instrument = Eigen::Vector3d(4, 0, 1);
  robot.uncertainty.emplace();
  robot.chain.links[0].max = std::numeric_limits<double>::infinity();
  robot.chain.links[1].min = -std::numeric_limits<double>::infinity();
  std::vector<std::string> expected = without;
  for (const std::string& name : {"instrument_mm", "uncertainty"}) expected.emplace_back(name);
  expected.push_back("min_deg of " + robot.chain.links[0].name);
  expected.push_back("max_deg of " + robot.chain.links[1].name);
  EXPECT_EQ(lost_in_urdf(robot), expected);
}

// The common normal of axes that are parallel within a milliradian lies hundreds of metres away.
TEST(Urdf, NearlyParallelAxesGetHayatisBeta) {
  const Robot robot = parse_urdf(kBranched, "r.urdf", kToTool);
  EXPECT_NEAR(robot.chain.links[2].d, 0.425, 1e-6);
  EXPECT_GT(std::abs(robot.chain.links[2].beta), 1e-5);
}

TEST(Urdf, TheBaseMayBeABranch) {
  const Robot from_base = parse_urdf(kBranched, "r.urdf", {"base", "tool0"});
  const Robot from_link = parse_urdf(kBranched, "r.urdf", kToTool);
  Pose turned;
  turned.rotation = Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (const JointVector& q : sample_joint_space(from_link.chain, 10)) {
    const Pose pose = turned * ChainEvaluator(from_base.chain).pose(q);
    EXPECT_LT((pose.translation - ChainEvaluator(from_link.chain).pose(q).translation).norm(),
              1e-9);
  }
}

TEST(Urdf, AnArmWithoutAnEndNamesTheEnds) {
  try {
    parse_urdf(kBranched, "r.urdf");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--tip tool0 (ends are tool0, sensor)"));
  }
  EXPECT_THROW(parse_urdf(kBranched, "r.urdf", {"base_link", "tool"}), InputError);
  EXPECT_EQ(joint_count(parse_urdf(kBranched, "r.urdf", {"l1", "tool0"}).chain), 5);
  EXPECT_THROW(parse_urdf(kBranched, "r.urdf", {"tool0", "base_link"}), InputError);
}

Robot calibrated(Robot robot) {
  for (int k = 0; k < kGeometricParameters; ++k)
    move_parameter(robot.chain, k, 1e-3 * std::sin(1.7 * k + 0.3));
  return robot;
}

TEST(Urdf, AUrdfHoldsTheCalibratedArmInItsOrigins) {
  const Robot robot = calibrated(parse_urdf(kBranched, "r.urdf", kToTool));
  const PatchedUrdf patched = write_into_urdf(robot, kBranched, "r.urdf", kToTool, {});
  expect_same_as_kdl(robot, patched.text);
  EXPECT_GT(patched.tool.distance, 1e-4);
  // Nothing but numbers of origins has changed.
  const std::regex origin("(xyz|rpy)=(\"[^\"]*\"|'[^']*') ?| ?<origin */>");
  std::string expected = std::regex_replace(std::string(kBranched), origin, "");
  std::string found = std::regex_replace(patched.text, origin, "");
  const std::regex empty(" *\\n? *<origin */>");
  EXPECT_EQ(std::regex_replace(found, empty, ""), std::regex_replace(expected, empty, ""));
}

TEST(Urdf, WithoutAChangeEveryByteStays) {
  const Robot robot = parse_urdf(kBranched, "r.urdf", kToTool);
  EXPECT_EQ(write_into_urdf(robot, kBranched, "r.urdf", kToTool, {}).text, kBranched);
}

TEST(Urdf, BaseAndToolMayStay) {
  Robot robot = calibrated(parse_urdf(kBranched, "r.urdf", kToTool));
  const Robot nominal = parse_urdf(kBranched, "r.urdf", kToTool);
  const PatchedUrdf patched = write_into_urdf(robot, kBranched, "r.urdf", kToTool, {true, true});
  robot.chain.base = nominal.chain.base;
  robot.chain.tool = nominal.chain.tool;
  robot.chain.links[kLinks - 1] = nominal.chain.links[kLinks - 1];
  expect_same_as_kdl(robot, patched.text);
  EXPECT_EQ(patched.base.distance, 0);
  EXPECT_EQ(patched.tool.distance, 0);
}

TEST(Urdf, AnotherArmIsAnError) {
  const Robot robot = calibrated(parse_urdf(kBranched, "r.urdf", kToTool));
  Robot longer = robot;
  longer.chain.links[3].d += 0.1;
  EXPECT_THROW(write_into_urdf(longer, kBranched, "r.urdf", kToTool, {}), InputError);
}

// A link that turns with the last joint stands on its axis.
TEST(Urdf, AToolThatFitsNowhereIsLeftOut) {
  const UrdfEnds to_link{"base_link", "l6"};
  const Robot nominal = parse_urdf(kBranched, "r.urdf", to_link);
  Robot robot = calibrated(nominal);
  const PatchedUrdf left = write_into_urdf(robot, kBranched, "r.urdf", to_link, {});
  const PatchedUrdf kept = write_into_urdf(robot, kBranched, "r.urdf", to_link, {false, true});
  EXPECT_EQ(left.text, kept.text);
  EXPECT_GT(left.tool_left_out.distance, 1e-5);
  EXPECT_EQ(left.tool_left_out.of_link, "l6");
  EXPECT_EQ(left.tool.distance, 0);
  EXPECT_EQ(kept.tool_left_out.distance, 0);
}

TEST(Urdf, MacrosThatNobodyExpandedAreAnError) {
  try {
    parse_urdf("<robot name=\"x\"><xacro:arm/></robot>", "x.urdf.xacro");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("xacro x.urdf.xacro > robot.urdf"));
  }
}

TEST(Urdf, WhatIsNoArmIsAnError) {
  EXPECT_THROW(parse_urdf("<robot", "r"), InputError);
  EXPECT_THROW(parse_urdf("<robot name=\"x\"><link name=\"a\"/></robot>", "r"), InputError);
}

}  // namespace
}  // namespace armtrue::urdf_io_test
