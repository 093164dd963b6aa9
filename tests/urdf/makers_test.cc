// The descriptions of ten makers, in small: tests/urdf/makers holds arms with the joints, origins,
// axes and limits of the public descriptions of their makers, and with what is peculiar to each.
// The numbers come from ros-industrial (kuka_experimental, abb, fanuc, motoman,
// staubli_experimental), iiwa_stack, doosan-robot, franka_ros, ros_kortex, xarm_ros and
// ur_description; the files are none of theirs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml.h>

#include <algorithm>
#include <iterator>
#include <random>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf/urdf_distance.h"

namespace armtrue::makers_test {
namespace {

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
    {"urdf/makers/abb_irb120.urdf", {"base_link", "tool0"}, {}, {}},
    {"urdf/makers/abb_irb6700_200_260.urdf", {"base_link", "tool0"}, {}, {}},
    {"urdf/makers/doosan_m1013.urdf", {"base_0", "link6"}, {false, true}, {}},
    {"urdf/makers/fanuc_r2000ic_165f.urdf", {"base_link", "tool0"}, {}, {"base"}, true},
    {"urdf/makers/franka_panda.urdf", {"panda_link0", "panda_hand"}, {}, {}, true},
    {"urdf/makers/kinova_gen3.urdf", {"base_link", "end_effector_link"}, {}, {}},
    {"urdf/makers/kuka_iiwa7.urdf", {"world", "iiwa_link_ee_kuka"}, {}, {}, true},
    {"urdf/makers/kuka_kr10_r1100.urdf", {"base_link", "tool0"}, {}, {}, true},
    {"urdf/makers/kuka_kr210_r2700.urdf", {"base_link", "tool0"}, {}, {}},
    {"urdf/makers/staubli_tx2_90.urdf", {"base_link", "tool0"}, {}, {"base"}, true},
    {"urdf/makers/ufactory_xarm6_on_rail.urdf",
     {"world", "link_eef"},
     {},
     {"camera", "table"},
     true},
    {"urdf/makers/yaskawa_gp25.urdf", {"base", "tool0"}, {}, {}},
    {"cli/convert-robot/into-urdf/cobot.urdf", {"world", "tool0"}, {}, {"base"}, true},
};

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
    const bool may_change = parent && parent->ValueStr() == "joint" &&
                            node.Parent()->ValueStr() == "robot" && child->ValueStr() == "origin" &&
                            joints.contains(parent->Attribute("name"));
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

// A tag with other blanks and quotes, and something behind it that looks like more of the joint.
std::string rewritten(std::string tag, std::mt19937_64& random) {
  static const char* const kBlanks[] = {" ", "  ", "\n\t", "\r\n    "};
  static const char* const kBehind[] = {"",
                                        "",
                                        "<!-- <origin xyz=\"9 9 9\"/> -->",
                                        "\n",
                                        "<!-- it's </joint> -->",
                                        "<?a <joint name='joint1'>?>"};
  const auto one_of = [&](const auto& texts) { return texts[random() % std::size(texts)]; };
  const char* const blanks = one_of(kBlanks);
  tag = std::regex_replace(tag, std::regex("\\s+(\\w+)="), blanks + std::string("$1 = "));
  if (random() % 2 == 0) tag = std::regex_replace(tag, std::regex("=\\s*\"([^\"']*)\""), "='$1'");
  if (random() % 2 == 0)
    tag = std::regex_replace(tag, std::regex("(xyz\\s*=\\s*\\S[^\"']*.)(\\s+)(rpy[^/>]*[\"'])"),
                             "$3$2$1");
  return tag + one_of(kBehind);
}

// The same document as somebody else would have written it.
std::string rewritten_document(const std::string& text, std::mt19937_64& random) {
  const std::regex part("<!--[^]*?-->|<!\\[CDATA\\[[^]*?\\]\\]>|<[!?][^>]*>|<[^>]*>");
  std::string result;
  size_t copied = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), part), end; it != end; ++it) {
    const auto begin = static_cast<size_t>(it->position());
    result.append(text, copied, begin - copied);
    const std::string own = it->str();
    copied = begin + own.size();
    const bool is_tag = own[1] != '!' && own[1] != '?' && own != "</robot>";
    result += is_tag ? rewritten(own, random) : own;
  }
  return result.append(text, copied);
}

TEST_P(MakersDescription, MayBeWrittenInAnyWay) {
  const Maker& maker = GetParam();
  const std::string original = read_test_file(maker.file);
  const Robot robot = built_arm(parse_urdf(original, maker.file, maker.ends), maker.kept);
  std::mt19937_64 random(11);
  for (int k = 0; k < 6; ++k) {
    const std::string text = rewritten_document(original, random);
    ASSERT_NE(text, original);
    const std::string patched =
        write_into_urdf(robot, text, maker.file, maker.ends, maker.kept).text;
    EXPECT_EQ(without_origins(patched), without_origins(text));
    Robot expected = robot;
    if (maker.kept.tool)
      expected.chain.links.back() = parse_urdf(text, maker.file, maker.ends).chain.links.back();
    const Distance distance =
        distance_between(UrdfArm(patched, maker.ends.base, maker.ends.tip), expected.chain);
    EXPECT_LT(distance.place, 1e-9) << text;
    EXPECT_LT(distance.attitude, 1e-9);
  }
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

// A parallel linkage closes a chain; a wrong parent leaves a circle beside the tree.
TEST(MakersJoints, WhatIsNoTreeIsNamed) {
  const Maker& abb = maker_of("irb120");
  const std::string text = read_test_file(abb.file);
  const auto message = [&](const std::string& from, const std::string& to) -> std::string {
    try {
      parse_urdf(std::regex_replace(text, std::regex(from), to), "r.urdf");
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message("</robot>",
                      "<joint name=\"rod\" type=\"fixed\"><parent link=\"link_4\"/>"
                      "<child link=\"link_2\"/></joint></robot>"),
              testing::HasSubstr("the link 'link_2' is the child of 'joint_2' and of 'rod'"));
  EXPECT_THAT(message("<child link=\"link_3\"", "<child link=\"base_link\""),
              testing::ContainsRegex(
                  "r.urdf:[0-9]+: the joints that lead to the link 'base' form a circle"));
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
