// The starters of config/robots are the arms of their makers' descriptions (see makers_test.cc), by
// urdfdom and KDL.

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/urdf_distance.h"

namespace armtrue::starters_test {
namespace {

using oracle::RightAngles;
using oracle::UrdfArm;

struct Starter {
  std::string name, file;
  UrdfEnds ends;  // from the frame of the controller to its flange
  bool has_travels_of_maker = true;
  // Of a sister of the arm in the file: `xyz` of the origins in which it differs.
  std::vector<std::pair<std::string, std::string>> origins = {};
};

std::ostream& operator<<(std::ostream& stream, const Starter& starter) {
  return stream << starter.name;
}

const Starter kStarters[] = {
    {"gp25", "urdf/makers/yaskawa_gp25.urdf", {"base", "tool0"}},
    {"iiwa7", "urdf/makers/kuka_iiwa7.urdf", {"world", "iiwa_link_ee_kuka"}},
    {"irb120", "urdf/makers/abb_irb120.urdf", {"base", "tool0"}},
    {"irb6700-200-260", "urdf/makers/abb_irb6700_200_260.urdf", {"base", "tool0"}},
    {"kr10-r1100", "urdf/makers/kuka_kr10_r1100.urdf", {"base", "tool0"}},
    {"kr210-r2700", "urdf/makers/kuka_kr210_r2700.urdf", {"base", "tool0"}},
    {"m1013", "urdf/makers/doosan_m1013.urdf", {"base_0", "link6"}},
    {"panda", "urdf/makers/franka_panda.urdf", {"panda_link0", "panda_link8"}},
    {"r2000ic-165f", "urdf/makers/fanuc_r2000ic_165f.urdf", {"base", "tool0"}},
    {"tx2-90", "urdf/makers/staubli_tx2_90.urdf", {"base", "tool0"}},
    {"iiwa14",
     "urdf/makers/kuka_iiwa7.urdf",
     {"world", "iiwa_link_ee_kuka"},
     true,
     {{"iiwa_joint_1", "0 0 0.1575"},
      {"iiwa_joint_2", "0 0 0.2025"},
      {"iiwa_joint_3", "0 0.2045 0"},
      {"iiwa_joint_4", "0 0 0.2155"},
      {"iiwa_joint_5", "0 0.1845 0"},
      {"iiwa_joint_6", "0 0 0.2155"},
      {"iiwa_joint_7", "0 0.081 0"}}},
    // ur_description halves the travel of the elbow for planners.
    {"ur5e", "cli/convert-robot/into-urdf/cobot.urdf", {"base", "tool0"}, false},
    {"ur3e",
     "cli/convert-robot/into-urdf/cobot.urdf",
     {"base", "tool0"},
     false,
     {{"shoulder_pan_joint", "0 0 0.15185"},
      {"elbow_joint", "-0.24355 0 0"},
      {"wrist_1_joint", "-0.2132 0 0.13105"},
      {"wrist_2_joint", "0 -0.08535 0"},
      {"wrist_3_joint", "0 0.0921 0"}}},
    {"ur10e",
     "cli/convert-robot/into-urdf/cobot.urdf",
     {"base", "tool0"},
     false,
     {{"shoulder_pan_joint", "0 0 0.1807"},
      {"elbow_joint", "-0.6127 0 0"},
      {"wrist_1_joint", "-0.57155 0 0.17415"},
      {"wrist_2_joint", "0 -0.11985 0"},
      {"wrist_3_joint", "0 0.11655 0"}}},
};

// The document with another origin of one joint.
std::string with_xyz(const std::string& text, const std::string& joint, const std::string& xyz) {
  const size_t begin = text.find("<joint name=\"" + joint + "\" type");
  const size_t value = text.find("xyz=", text.find("<origin", begin)) + 5;
  const size_t end = text.find(text[value - 1], value);
  return text.substr(0, value) + xyz + text.substr(end);
}

// The document of a starter, with right angles that are no farther off than 1e-7.
std::string document_of(const Starter& starter) {
  std::string text = read_test_file(starter.file);
  for (const auto& [joint, xyz] : starter.origins) text = with_xyz(text, joint, xyz);
  return std::regex_replace(text, std::regex("1\\.571"), "1.5707963267948966");
}

class MakersStarter : public testing::TestWithParam<Starter> {};

TEST_P(MakersStarter, IsTheArmOfTheMakersDescription) {
  const Starter& starter = GetParam();
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + starter.name + ".yaml").robot;
  const UrdfArm arm(document_of(starter), starter.ends.base, starter.ends.tip, RightAngles::exact);
  const Distance distance = distance_between(arm, robot.chain);
  EXPECT_LT(distance.place, 1e-9);
  EXPECT_LT(distance.attitude, 1e-9);
  if (!starter.has_travels_of_maker) return;
  int joint = 0;
  for (const oracle::UrdfJoint& expected : arm.joints())
    if (expected.is_driven) {
      const Link& link = joint_link(robot.chain, joint++);
      EXPECT_NEAR(link.min, expected.lower, 0.02 * kDegree) << link.name;
      EXPECT_NEAR(link.max, expected.upper, 0.02 * kDegree) << link.name;
    }
}

// Whoever begins with a starter gets the calibrated arm into the maker's file, too: the frames of
// both are others, the axes the same.
TEST_P(MakersStarter, GoesIntoTheMakersDescriptionWhenCalibrated) {
  const Starter& starter = GetParam();
  const std::string text = document_of(starter);
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + starter.name + ".yaml").robot;
  // Where the document ends at the link of joint 6, it has no place for what lies behind axis 6.
  const bool has_place_for_tool = starter.name != "m1013";
  const int links = find_parameter(robot.chain, robot.chain.links[0].name + ".alpha").value();
  const char* const first_left = has_place_for_tool ? "tool.x" : "J6.alpha";
  const int behind = find_parameter(robot.chain, first_left).value();
  for (int k = links; k < behind; ++k)
    move_parameter(robot.chain, k, 5e-4 * std::sin(1.7 * k + 0.3));
  // The instrument's frame stands anywhere, the reflector on a bracket.
  robot.chain.base.translation = {3, -2, 1};
  robot.chain.base.rotation = rotation_from_abc(2, 0.4, -0.3);
  if (has_place_for_tool) robot.chain.tool.translation = {0.04, 0.01, 0.03};
  const UrdfKept kept{false, !has_place_for_tool};
  const PatchedUrdf patched = write_into_urdf(robot, text, starter.file, starter.ends, kept);
  EXPECT_NEAR(patched.base.distance, robot.chain.base.translation.norm(), 0.01);
  Distance distance =
      distance_between(UrdfArm(patched.text, starter.ends.base, starter.ends.tip), robot.chain);
  EXPECT_LT(distance.place, 1e-9);
  EXPECT_LT(distance.attitude, 1e-9);
  // Seen from its own foot it is the arm in the same place.
  const UrdfArm foot(
      write_into_urdf(robot, text, starter.file, starter.ends, {true, kept.tool}).text,
      starter.ends.base, starter.ends.tip);
  robot.chain.base = {};
  distance = distance_between(foot, robot.chain);
  EXPECT_LT(distance.place, 1e-9);
  EXPECT_LT(distance.attitude, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, MakersStarter, testing::ValuesIn(kStarters), [](const auto& info) {
  return std::regex_replace(info.param.name, std::regex("[^a-z0-9]"), "_");
});

}  // namespace
}  // namespace armtrue::starters_test
