// The descriptions of ten makers, in small: tests/io/urdf holds arms with the joints, origins, axes
// and limits of the public descriptions of their makers, and with what is peculiar to each. The
// numbers come from ros-industrial (kuka_experimental, abb, fanuc, motoman, staubli_experimental),
// iiwa_stack, doosan-robot, franka_ros, ros_kortex, xarm_ros and ur_description; the files are none
// of theirs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/io/urdf/urdf_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "urdf_kinematics.h"

namespace armtrue::makers_test {
namespace {

using oracle::RightAngles;
using oracle::UrdfArm;

struct Maker {
  std::string file;
  UrdfEnds ends;                    // of the calibrated arm
  UrdfKept kept;                    // what the document has no place for
  std::vector<std::string> beside;  // links that are named as a possible frame of the controller
  bool needs_tip = false;           // several links end the arm
};

std::ostream& operator<<(std::ostream& stream, const Maker& maker) { return stream << maker.file; }

const Maker kMakers[] = {
    {"io/urdf/abb_irb120.urdf", {"base_link", "tool0"}, {}, {}},
    {"io/urdf/abb_irb6700_200_260.urdf", {"base_link", "tool0"}, {}, {}},
    {"io/urdf/doosan_m1013.urdf", {"base_0", "link6"}, {false, true}, {}},
    {"io/urdf/fanuc_r2000ic_165f.urdf", {"base_link", "tool0"}, {}, {"base"}, true},
    {"io/urdf/franka_panda.urdf", {"panda_link0", "panda_hand"}, {}, {}, true},
    {"io/urdf/kinova_gen3.urdf", {"base_link", "end_effector_link"}, {}, {}},
    {"io/urdf/kuka_iiwa7.urdf", {"world", "iiwa_link_ee_kuka"}, {}, {}, true},
    {"io/urdf/kuka_kr10_r1100.urdf", {"base_link", "tool0"}, {}, {}, true},
    {"io/urdf/kuka_kr210_r2700.urdf", {"base_link", "tool0"}, {}, {}},
    {"io/urdf/staubli_tx2_90.urdf", {"base_link", "tool0"}, {}, {"base"}, true},
    {"io/urdf/ufactory_xarm6_on_rail.urdf", {"world", "link_eef"}, {}, {"camera"}, true},
    {"io/urdf/yaskawa_gp25.urdf", {"base", "tool0"}, {}, {}},
    {"cli/convert-robot/into-urdf/cobot.urdf", {"world", "tool0"}, {}, {"base"}, true},
};

std::string read_test_file(const std::string& name) {
  std::ifstream file(std::string(ARMTRUE_TESTS "/") + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Random values of the driven joints within their limits.
std::vector<double> random_joints(const UrdfArm& arm, std::mt19937_64& random) {
  std::vector<double> q;
  for (const oracle::UrdfJoint& joint : arm.joints())
    if (joint.is_driven)
      q.push_back(std::uniform_real_distribution(joint.lower, joint.upper)(random));
  return q;
}

struct Distance {
  double place = 0, attitude = 0;  // [m], of matrix entries
};

// The largest of 50 random poses between the arm of a document and a robot.
Distance distance_between(const UrdfArm& arm, const KinematicChain& chain) {
  const ChainEvaluator evaluator(chain);
  std::mt19937_64 random(7);
  Distance result;
  for (int k = 0; k < 50; ++k) {
    const std::vector<double> q = random_joints(arm, random);
    const KDL::Frame expected = arm.pose(q);
    const Pose pose =
        evaluator.pose(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<long>(q.size())));
    for (int row = 0; row < 3; ++row) {
      result.place = std::max(result.place, std::abs(pose.translation[row] - expected.p(row)));
      for (int column = 0; column < 3; ++column)
        result.attitude = std::max(
            result.attitude, std::abs(pose.rotation(row, column) - expected.M(row, column)));
    }
  }
  return result;
}

// ---- The starters of config/robots ----

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
    {"gp25", "io/urdf/yaskawa_gp25.urdf", {"base", "tool0"}},
    {"iiwa7", "io/urdf/kuka_iiwa7.urdf", {"world", "iiwa_link_ee_kuka"}},
    {"irb120", "io/urdf/abb_irb120.urdf", {"base", "tool0"}},
    {"irb6700-200-260", "io/urdf/abb_irb6700_200_260.urdf", {"base", "tool0"}},
    {"kr10-r1100", "io/urdf/kuka_kr10_r1100.urdf", {"base", "tool0"}},
    {"kr210-r2700", "io/urdf/kuka_kr210_r2700.urdf", {"base", "tool0"}},
    {"m1013", "io/urdf/doosan_m1013.urdf", {"base_0", "link6"}},
    {"panda", "io/urdf/franka_panda.urdf", {"panda_link0", "panda_link8"}},
    {"r2000ic-165f", "io/urdf/fanuc_r2000ic_165f.urdf", {"base", "tool0"}},
    {"tx2-90", "io/urdf/staubli_tx2_90.urdf", {"base", "tool0"}},
    {"iiwa14",
     "io/urdf/kuka_iiwa7.urdf",
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

class MakersStarter : public testing::TestWithParam<Starter> {};

TEST_P(MakersStarter, IsTheArmOfTheMakersDescription) {
  const Starter& starter = GetParam();
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + starter.name + ".yaml").robot;
  std::string text = read_test_file(starter.file);
  for (const auto& [joint, xyz] : starter.origins) text = with_xyz(text, joint, xyz);
  const UrdfArm arm(text, starter.ends.base, starter.ends.tip, RightAngles::exact);
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

INSTANTIATE_TEST_SUITE_P(All, MakersStarter, testing::ValuesIn(kStarters), [](const auto& info) {
  return std::regex_replace(info.param.name, std::regex("[^a-z0-9]"), "_");
});

// ---- From the description to the calibrated arm and back ----

// A document without the origins of its joints' frames, links and all: what may not change.
std::string without_origins(const std::string& text) {
  return std::regex_replace(text, std::regex("\\s*<origin[^>]*>"), "");
}

// Names, attributes and texts of all elements, but not of the origins of `joints`.
void list_elements(const TiXmlNode& node, const std::set<std::string>& joints,
                   std::vector<std::string>& result) {
  for (const TiXmlNode* child = node.FirstChild(); child; child = child->NextSibling()) {
    const TiXmlElement* const parent = node.ToElement();
    const bool may_change =
        parent && parent->ValueStr() == "joint" && node.Parent()->ValueStr() == "robot" &&
        child->ValueStr() == "origin" && joints.contains(parent->Attribute("name"));
    if (may_change) continue;
    std::string own = child->ValueStr();
    if (const TiXmlElement* const element = child->ToElement())
      for (const TiXmlAttribute* a = element->FirstAttribute(); a; a = a->Next())
        own += "|" + a->NameTStr() + "=" + a->ValueStr();
    result.push_back(own);
    list_elements(*child, joints, result);
  }
}

std::vector<std::string> elements_besides_origins(const std::string& text,
                                                  const std::set<std::string>& joints) {
  TiXmlDocument document;
  document.Parse(text.c_str());
  EXPECT_FALSE(document.Error()) << document.ErrorDesc();
  std::vector<std::string> result;
  list_elements(document, joints, result);
  return result;
}

// An arm as it comes from the factory: each length and angle a little off, the foot somewhere else,
// the reflector on a bracket.
Robot built_arm(Robot robot, const UrdfKept& kept) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> deviation;
  const int first = find_parameter(robot.chain, robot.chain.links[0].name + ".alpha").value();
  const int behind = find_parameter(robot.chain, "tool.x").value();
  for (int k = first; k < behind; ++k) {
    const bool is_length = parameter_unit(robot.chain, k) == ParameterUnit::metre;
    move_parameter(robot.chain, k,
                   (is_length ? 0.4 * kMillimetre : 0.5 * kMilliradian) * deviation(random));
  }
  robot.chain.base.translation += Eigen::Vector3d(0.003, -0.002, 0.001);
  if (!kept.tool) robot.chain.tool.translation += Eigen::Vector3d(0.04, 0.01, 0.03);
  return robot;
}

class MakersDescription : public testing::TestWithParam<Maker> {};

TEST_P(MakersDescription, HoldsTheCalibratedArmInItsOrigins) {
  const Maker& maker = GetParam();
  const std::string text = read_test_file(maker.file);
  // Through the text of a robot file, as the commands pass it on.
  const auto through_yaml = [](const Robot& robot) {
    return parse_robot(write_robot(robot), "r.yaml");
  };
  const Robot nominal = through_yaml(parse_urdf(text, maker.file, maker.ends));
  EXPECT_EQ(write_into_urdf(nominal, text, maker.file, maker.ends, maker.kept).text, text);

  const Robot truth = built_arm(nominal, maker.kept);
  SimulationOptions options;
  options.poses = 40;
  options.noise_position = 0.02 * kMillimetre;
  options.noise_orientation = 0.1 * kMilliradian;
  Robot calibrated = through_yaml(calibrate(nominal, simulate(nominal, truth, options)).robot);
  const std::string patched =
      write_into_urdf(calibrated, text, maker.file, maker.ends, maker.kept).text;

  const UrdfArm before(text, maker.ends.base, maker.ends.tip);
  const UrdfArm after(patched, maker.ends.base, maker.ends.tip);
  std::set<std::string> joints;
  for (const oracle::UrdfJoint& joint : before.joints()) joints.insert(joint.name);
  EXPECT_EQ(without_origins(patched), without_origins(text));
  EXPECT_EQ(elements_besides_origins(patched, joints), elements_besides_origins(text, joints));

  if (maker.kept.tool) {
    calibrated.chain.tool = nominal.chain.tool;
    calibrated.chain.links.back() = nominal.chain.links.back();
  }
  const Distance distance = distance_between(after, calibrated.chain);
  EXPECT_LT(distance.place, 1e-9);
  EXPECT_LT(distance.attitude, 1e-9);
  // The document says where the arm that was measured stands; before, it missed by millimetres.
  EXPECT_GT(distance_between(before, truth.chain).place, 3 * kMillimetre);
  EXPECT_LT(distance_between(after, truth.chain).place, 0.3 * kMillimetre);
}

TEST_P(MakersDescription, NamesTheFrameOfTheControllerAndTheEnds) {
  const Maker& maker = GetParam();
  const std::string text = read_test_file(maker.file);
  EXPECT_EQ(frames_beside_base(text, maker.file, maker.ends), maker.beside);
  const UrdfEnds no_tip{maker.ends.base, ""};
  if (!maker.needs_tip) {
    EXPECT_EQ(write_robot(parse_urdf(text, maker.file, no_tip)),
              write_robot(parse_urdf(text, maker.file, maker.ends)));
    return;
  }
  try {
    parse_urdf(text, maker.file, no_tip);
    ADD_FAILURE();
  } catch (const InputError& error) {
    const bool has_tool0 = maker.ends.tip == "tool0";
    EXPECT_THAT(error.what(), testing::HasSubstr(has_tool0 ? "--tip tool0 (" : "--tip "));
  }
}

// What the source of each description may still hold where nobody ran xacro.
TEST_P(MakersDescription, IsRefusedWhereXacroHasNotExpandedIt) {
  const Maker& maker = GetParam();
  const std::string text = read_test_file(maker.file);
  const size_t end = text.rfind("</robot>");
  for (const char* left : {"<xacro:arm prefix=\"\"/>", "<link name='${prefix}tool1'/>",
                           "<limit lower=\"-${radians(170)}\"/>",
                           "<xacro:include filename=\"$(find abb_resources)/urdf/a.xacro\"/>",
                           "<a b=\"$(arg name)\"/>"}) {
    std::string source = text;
    source.insert(end, left);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(end), '\n');
    try {
      parse_urdf(source, "arm.xacro", maker.ends);
      ADD_FAILURE() << left;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("arm.xacro:" + std::to_string(line) + ": "));
      EXPECT_THAT(error.what(), testing::HasSubstr("xacro arm.xacro > robot.urdf"));
    }
    source.insert(end, "<!-- ").insert(end + 5 + std::string(left).size(), " -->");
    EXPECT_NO_THROW(parse_urdf(source, "arm.urdf", maker.ends)) << left;
  }
}

INSTANTIATE_TEST_SUITE_P(All, MakersDescription, testing::ValuesIn(kMakers), [](const auto& info) {
  const std::string& file = info.param.file;
  return std::regex_replace(file.substr(file.rfind('/') + 1), std::regex("\\.urdf$"), "");
});

// ---- What single descriptions are about ----

const Maker& maker_of(const std::string& part) {
  return *std::ranges::find_if(
      kMakers, [&](const Maker& maker) { return maker.file.find(part) != std::string::npos; });
}

// At a pitch of 90 deg that is rounded to eight digits, roll and yaw have eight wrong digits.
TEST(MakersOrigins, AToolThatPointsAlongXKeepsItsAttitude) {
  const Maker& kuka = maker_of("kr10");
  const std::string text = read_test_file(kuka.file);
  Robot robot = parse_urdf(text, kuka.file, kuka.ends);
  for (size_t j = 0; j < 6; ++j) robot.chain.links[j].theta += 0.001;
  robot.chain.tool.translation.x() += 0.01;
  const std::string patched = write_into_urdf(robot, text, kuka.file, kuka.ends, {}).text;
  EXPECT_LT(distance_between(UrdfArm(patched, "base_link", "tool0"), robot.chain).attitude, 1e-12);
}

TEST(MakersOrigins, AnOriginThatIsAddedStandsInALineOfItsOwn) {
  const Maker& kuka = maker_of("kr10");
  const std::string text = read_test_file(kuka.file);
  Robot robot = parse_urdf(text, kuka.file, kuka.ends);
  robot.chain.links[4].r += 0.001;
  EXPECT_THAT(write_into_urdf(robot, text, kuka.file, kuka.ends, {}).text,
              testing::ContainsRegex("joint_a5\" type=\"revolute\">\r\n    <origin xyz=\"0 0.00"));
}

TEST(MakersJoints, ARailMovesALinkWhoseNameMeansSomethingElse) {
  const Maker& cell = maker_of("rail");
  const Robot robot = parse_urdf(read_test_file(cell.file), cell.file, cell.ends);
  EXPECT_EQ(robot.chain.links[0].name, "rail");
  EXPECT_EQ(robot.chain.links[1].name, "link1");
}

TEST(MakersJoints, AJointThatFollowsAnotherIsNoPartOfAnArm) {
  const Maker& abb = maker_of("6700");
  try {
    parse_urdf(read_test_file(abb.file), abb.file, {"base_link", "piston"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("'cylinder_joint' follows 'joint_2' (mimic)"));
  }
}

TEST(MakersJoints, TheArmOfAGripperEndsAtItsPalm) {
  const Maker& cell = maker_of("rail");
  try {
    parse_urdf(read_test_file(cell.file), cell.file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("--tip xarm_gripper_base_link (ends are "));
  }
}

}  // namespace
}  // namespace armtrue::makers_test
