// From the URDF of a maker to a program that is right: the arm of the description is built with other
// lengths and zeros, measured, calibrated, and programs of its flange are corrected. urdfdom and KDL
// say where the flange of the built arm stands. Eleven structures stand in the public descriptions of
// as many makers: how axes point, what turns and lengths lie behind the last joint, what stands
// beside the foot, how right angles are rounded. The lengths are none of theirs.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <kdl/frames.hpp>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/compensation/compensation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "urdf_kinematics.h"

namespace armtrue::flange_test {
namespace {

using oracle::UrdfArm;

// The joints of a structure, a line each: parent, child, xyz and rpy of the origin, and the axis of
// the six that turn.
struct Maker {
  std::string name;
  std::string joints;
  UrdfEnds ends;  // from the controller's base to its flange
};

std::ostream& operator<<(std::ostream& stream, const Maker& maker) { return stream << maker.name; }

const Maker kMakers[] = {
    // Axes against x and z; behind the last one a flange for ROS, and the controller's, which points
    // against the axis.
    {"kuka", R"(
base_link base    0 0 0          0 0 0
base_link link_1  0 0 0.385      0 0 0          0 0 -1
link_1    link_2  0.031 0 0      0 0 0          0 1 0
link_2    link_3  0.462 0 0      0 0 0          0 1 0
link_3    link_4  0 0 0.027      0 0 0         -1 0 0
link_4    link_5  0.431 0 0      0 0 0          0 1 0
link_5    link_6  0 0 0          0 0 0         -1 0 0
link_6    flange  0.094 0 0      0 0 0
flange    tool0   0 0 0          0 1.5707963267948966 0)",
     {"base", "tool0"}},
    // The same maker, by another author: all axes are z, and pi has four digits.
    {"kuka_all_z", R"(
base_link base    0 0 0          0 0 0
base_link link_1  0 0 0.3056     -3.1416 0 0    0 0 1
link_1    link_2  0.29 0 -0.34   1.5708 0 0     0 0 1
link_2    link_3  1.12 0 0       0 0 -1.5708    0 0 1
link_3    link_4  -0.12 -0.6 0   1.5708 0 0     0 0 1
link_4    link_5  0 0 -0.55      -1.5708 0 0    0 0 1
link_5    link_6  0 -0.14 0      1.5708 0 0     0 0 1
link_6    flange  0 0 -0.075     -3.1416 0 3.1416
flange    tool0   0 0 0          0 0 0)",
     {"base", "tool0"}},
    // The base of the controller at the height of axis 2; the face plate 158 mm before axis 6 ends.
    {"fanuc", R"(
base_link base    0 0 0.64       0 0 0
base_link link_1  0 0 0.64       0 0 0          0 0 1
link_1    link_2  0.305 0 0      0 0 0          0 1 0
link_2    link_3  0 0 1.08       0 0 0          0 -1 0
link_3    link_4  0 0 0.22       0 0 0         -1 0 0
link_4    link_5  1.27 0 0       0 0 0          0 -1 0
link_5    link_6  0 0 0          0 0 0         -1 0 0
link_6    flange  0.158 0 0      3.1415926535 0 0
flange    tool0   0 0 0          3.1415926535 -1.570796327 0)",
     {"base", "tool0"}},
    // The last link is turned, and the flange stands a length before it.
    {"abb", R"(
base_link base    0 0 0          0 0 0
base_link link_1  0 0 0          0 0 0          0 0 1
link_1    link_2  0.31 0 0.77    0 0 0          0 1 0
link_2    link_3  0 0 1.06       0 0 0          0 1 0
link_3    link_4  0 0 0.19       0 0 0          1 0 0
link_4    link_5  1.14 0 0       0 0 0          0 1 0
link_5    link_6  0.19 0 0       0 0 0          1 0 0
link_6    tool0   0.055 0 0      0 1.57079632679 0)",
     {"base", "tool0"}},
    // The base of the controller is half a turn off the base of ROS, two turns lead to its flange.
    {"universal_robots", R"(
base_link base              0 0 0            0 0 3.141592653589793
base_link base_link_inertia 0 0 0            0 0 3.141592653589793
base_link_inertia shoulder  0 0 0.151        0 0 0                      0 0 1
shoulder  upper_arm         0 0 0            1.570796327 0 0            0 0 1
upper_arm forearm           -0.43 0 0        0 0 0                      0 0 1
forearm   wrist_1           -0.38 0 0.127    0 0 0                      0 0 1
wrist_1   wrist_2           0 -0.101 0       1.570796327 0 0            0 0 1
wrist_2   wrist_3           0 0.098 0        1.570796326589793 3.141592653589793 3.141592653589793 0 0 1
wrist_3   ft_frame          0 0 0            3.141592653589793 0 0
wrist_3   flange            0 0 0            0 -1.5707963267948966 -1.5707963267948966
flange    tool0             0 0 0            1.5707963267948966 0 1.5707963267948966)",
     {"base", "tool0"}},
    // Joints 3 to 6 count the other way; the flange has no link of its own between.
    {"yaskawa", R"(
base_link base     0 0 0.505     0 0 0
base_link link_1_s 0 0 0.505     0 0 0          0 0 1
link_1_s  link_2_l 0.15 0 0      0 0 0          0 1 0
link_2_l  link_3_u 0 0 0.76      0 0 0          0 -1 0
link_3_u  link_4_r 0 0 0.2       0 0 0         -1 0 0
link_4_r  link_5_b 0.795 0 0     0 0 0          0 -1 0
link_5_b  link_6_t 0 0 0         0 0 0         -1 0 0
link_6_t  tool0    0.1 0 0       3.1415926 -1.570796 0)",
     {"base", "tool0"}},
    // The flange has the frame of the last link.
    {"staubli", R"(
base_link base    0 0 0.478      0 0 0
base_link link_1  0 0 0.478      0 0 0          0 0 1
link_1    link_2  0.05 0 0       0 0 0          0 1 0
link_2    link_3  0 0.05 0.425   0 0 0          0 1 0
link_3    link_4  0 0 0          0 0 0          0 0 1
link_4    link_5  0 0 0.425      0 0 0          0 1 0
link_5    link_6  0 0 0.1        0 0 0          0 0 1
link_6    flange  0 0 0          0 -1.57079632679 0
link_6    tool0   0 0 0          0 0 0)",
     {"base", "tool0"}},
    // The arm ends in a link that turns with its last joint.
    {"kawasaki", R"(
world     base_link 0 0 0        0 0 0
base_link link1   0 0 0.43       0 0 0          0 0 -1
link1     link2   0 0.1 0        0 -1.5707963 0 0 0 1
link2     link3   0.51 0 0       0 0 0          0 0 -1
link3     link4   0.08 0 0       0 1.5707963 0  0 0 1
link4     link5   0 0 0.49       0 -1.5707963 0 0 0 -1
link5     link6   0.09 0 0       0 1.5707963 0  0 0 1)",
     {"base_link", "link6"}},
    {"denso", R"(
world     base_link 0 0 0        0 0 0
base_link J1      0 0 0.1815     0 0 0          0 0 1
J1        J2      0 0 0.17       0 0 0          0 1 0
J2        J3      0 0 0.31       0 0 0          0 1 0
J3        J4      -0.012 0 0.16  0 0 0          0 0 1
J4        J5      0 0 0.14       0 0 0          0 1 0
J5        J6      0 0 0.07       0 0 0          0 0 1)",
     {"base_link", "J6"}},
    // Right angles have three digits, and the arm has a shoulder to the side.
    {"doosan", R"(
world     base    0 0 0          0 0 0
base      link1   0 0 0.135      0 0 0          0 0 1
link1     link2   0 0.006 0      0 -1.571 -1.571 0 0 1
link2     link3   0.41 0 0       0 0 1.571      0 0 1
link3     link4   0 -0.37 0      1.571 0 0      0 0 1
link4     link5   0 0 0          -1.571 0 0     0 0 1
link5     link6   0 -0.12 0      1.571 0 0      0 0 1)",
     {"base", "link6"}},
    // The user's tip stands beyond the flange, askew, where a gripper has its palm.
    {"ufactory", R"(
world     link_base 0 0 0        0 0 0
link_base link1   0 0 0.26       0 0 0          0 0 1
link1     link2   0 0 0          -1.5708 0 0    0 0 1
link2     link3   0.053 -0.28 0  0 0 0          0 0 1
link3     link4   0.078 0.34 0   -1.5708 0 0    0 0 1
link4     link5   0 0 0          1.5708 0 0     0 0 1
link5     link6   0.074 0.095 0  -1.5708 0 0    0 0 1
link6     link_eef 0 0 0         0 0 0
link_eef  bracket 0.03 0 0.02    0 0.4 0
bracket   palm    0 0.015 0.09   0.2 0 1.1)",
     {"link_base", "palm"}},
};

// ---- The description and the arm that is built after it ----

struct Joint {
  std::string parent, child;
  KDL::Frame origin;
  bool turns = false;
  KDL::Vector axis;
};

std::vector<Joint> joints_of(const Maker& maker) {
  std::vector<Joint> joints;
  std::istringstream lines(maker.joints);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Joint joint;
    if (!(words >> joint.parent >> joint.child)) continue;
    std::array<double, 6> n{};
    for (double& number : n) words >> number;
    joint.origin = {KDL::Rotation::RPY(n[3], n[4], n[5]), KDL::Vector(n[0], n[1], n[2])};
    joint.turns = static_cast<bool>(words >> joint.axis(0) >> joint.axis(1) >> joint.axis(2));
    joints.push_back(joint);
  }
  return joints;
}

std::string urdf_of(const std::string& name, const std::vector<Joint>& joints) {
  std::string links = fmt::format("<link name=\"{}\"/>", joints.front().parent), all;
  for (const Joint& joint : joints) {
    double r = 0, p = 0, y = 0;
    joint.origin.M.GetRPY(r, p, y);
    links += fmt::format("<link name=\"{}\"/>\n", joint.child);
    all += fmt::format(
        "<joint name=\"to_{1}\" type=\"{2}\"><parent link=\"{0}\"/><child link=\"{1}\"/>"
        "<origin xyz=\"{3} {4} {5}\" rpy=\"{6} {7} {8}\"/>{9}</joint>\n",
        joint.parent, joint.child, joint.turns ? "revolute" : "fixed", joint.origin.p(0),
        joint.origin.p(1), joint.origin.p(2), r, p, y,
        joint.turns ? fmt::format("<axis xyz=\"{} {} {}\"/><limit lower=\"-2.2\" upper=\"1.9\" "
                                  "effort=\"1\" velocity=\"1\"/>",
                                  joint.axis(0), joint.axis(1), joint.axis(2))
                    : "");
  }
  return fmt::format("<robot name=\"{}\">\n{}{}</robot>\n", name, links, all);
}

KDL::Vector random_vector(std::mt19937_64& random, double size) {
  std::normal_distribution<double> deviation(0, size);
  const double x = deviation(random), y = deviation(random);
  return {x, y, deviation(random)};
}

KDL::Vector across(const KDL::Vector& v, const KDL::Vector& axis) {
  return v - axis * (KDL::dot(axis, v) / KDL::dot(axis, axis));
}

// Links and zeros of joints 2 to 5 are off. What no readings tell from the place of the instrument
// and of the reflector stays: joint 1, a turn about or a way along its axis behind it, and the same
// of joint 6.
std::vector<Joint> built(std::vector<Joint> joints, std::mt19937_64& random) {
  int turning = 0;
  KDL::Vector first_axis;
  for (Joint& joint : joints) {
    if (!joint.turns) continue;
    if (++turning == 1) {
      first_axis = joint.axis;
      continue;
    }
    KDL::Vector moved = random_vector(random, 0.4e-3), turned = random_vector(random, 0.8e-3);
    if (turning == 2) {
      const KDL::Vector axis = joint.origin.M.Inverse() * first_axis;
      moved = across(moved, axis);
      turned = across(turned, axis);
    }
    if (turning == 6) {
      moved = across(moved, joint.axis);
      turned = across(turned, joint.axis);
    }
    joint.origin = joint.origin * KDL::Frame(KDL::Rotation::Rot(turned, turned.Norm()), moved);
  }
  return joints;
}

Pose pose_of(const KDL::Frame& frame) {
  Pose pose;
  for (int row = 0; row < 3; ++row) {
    pose.translation[row] = frame.p(row);
    for (int column = 0; column < 3; ++column) pose.rotation(row, column) = frame.M(row, column);
  }
  return pose;
}

// An arm of six joints by KDL, where its description has base and tip.
class Arm {
 public:
  Arm(const std::string& urdf, const UrdfEnds& ends) : arm_(urdf, ends.base, ends.tip) {}
  KDL::Frame flange(const JointVector& q) const {
    return arm_.pose(std::vector<double>(q.data(), q.data() + q.size()));
  }

 private:
  UrdfArm arm_;
};

JointVector random_joints(std::mt19937_64& random) {
  JointVector q(6);
  for (double& angle : q) angle = std::uniform_real_distribution(-2.1, 1.8)(random);
  return q;
}

// Far enough from singular postures that a small correction stays small.
bool is_bent(const Arm& arm, const JointVector& q) {
  Eigen::Matrix<double, 6, 6> jacobian;
  const KDL::Frame here = arm.flange(q);
  for (int j = 0; j < 6; ++j) {
    JointVector moved = q;
    moved[j] += 1e-6;
    const KDL::Twist twist = KDL::diff(here, arm.flange(moved), 1e-6);
    for (int row = 0; row < 6; ++row) jacobian(row, j) = twist(row);
  }
  return jacobian.jacobiSvd().singularValues()[5] > 0.08;
}

// Where a tracker somewhere in the room sees a reflector on a bracket, to a micrometre.
Campaign measured(const Arm& arm, std::mt19937_64& random) {
  const KDL::Frame station(KDL::Rotation::RPY(0.3, -0.1, 2), KDL::Vector(1.3, -2.1, 0.4));
  const KDL::Frame bracket(KDL::Rotation::RPY(0.05, 0.2, -0.4), KDL::Vector(0.04, -0.03, 0.11));
  Campaign campaign;
  campaign.source = "measured.csv";
  for (int k = 0; k < 50; ++k) {
    const JointVector q = random_joints(random);
    const Pose seen = pose_of(station * arm.flange(q) * bracket *
                              KDL::Frame(KDL::Rotation::Identity(), random_vector(random, 1e-6)));
    campaign.pose.push_back(k);
    campaign.pose_ids.push_back(std::to_string(k));
    campaign.line.push_back(k + 2);
    campaign.q.push_back(q);
    campaign.position.push_back(seen.translation);
    campaign.orientation.emplace_back(seen.rotation);
  }
  return campaign;
}

// ---- What the chain of the commands does with it ----

class MakersFlange : public testing::TestWithParam<Maker> {};

Robot through_yaml(const Robot& robot) { return parse_robot(write_robot(robot), "r.yaml"); }

TEST_P(MakersFlange, IsTheFrameOfTheLastLink) {
  const Maker& maker = GetParam();
  const std::string urdf = urdf_of(maker.name, joints_of(maker));
  const Robot robot = through_yaml(parse_urdf(urdf, maker.name, maker.ends));
  EXPECT_EQ(robot.chain.tool.rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(robot.chain.tool.translation, Eigen::Vector3d::Zero());
  // R_0 has the axes of the base, and stands there but for the rounding of right angles.
  EXPECT_EQ(robot.chain.base.rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(foot_beside_base(urdf, maker.name, maker.ends), robot.chain.base.translation);
  const Arm arm(urdf, maker.ends);
  std::mt19937_64 random(1);
  for (int k = 0; k < 20; ++k) {
    const JointVector q = random_joints(random);
    const Pose expected = pose_of(arm.flange(q)), found = ChainEvaluator(robot.chain).pose(q);
    EXPECT_LT((found.translation - expected.translation).norm(), 1e-9);
    EXPECT_LT((found.rotation - expected.rotation).norm(), 1e-9);
  }
}

TEST_P(MakersFlange, StandsWhereACorrectedProgramWantsIt) {
  const Maker& maker = GetParam();
  std::mt19937_64 random(5);
  const std::vector<Joint> joints = joints_of(maker);
  const std::string urdf = urdf_of(maker.name, joints);
  const Arm drawn(urdf, maker.ends), arm(urdf_of(maker.name, built(joints, random)), maker.ends);

  Robot nominal = through_yaml(parse_urdf(urdf, maker.name, maker.ends));
  nominal.noise = {1e-6, 1e-6};
  const Robot identified = through_yaml(calibrate(nominal, measured(arm, random)).robot);

  const KDL::Frame tool(KDL::Rotation::RPY(0.2, 0.4, -0.5), KDL::Vector(0.03, -0.01, 0.2));
  CompensationOptions options;
  options.tool = pose_of(tool);
  options.max_correction = 50 * kMillimetre;
  Program program;
  program.visits.source = "targets.csv";
  while (program.rows() < 20) {
    const JointVector q = random_joints(random);
    if (!is_bent(drawn, q)) continue;
    const int row = program.rows();
    program.visits.pose.push_back(row);
    program.visits.pose_ids.push_back(std::to_string(row));
    program.visits.line.push_back(row + 2);
    program.visits.q.push_back(q);
    program.poses.push_back(pose_of(drawn.flange(q) * tool));
    program.hinted.push_back(true);
  }
  const std::vector<CorrectedTarget> targets = compensate(identified, nominal, program, options);
  double worst = 0, before = 0;
  for (size_t k = 0; k < targets.size(); ++k) {
    const auto distance = [&](const JointVector& q) {
      const Pose stands = pose_of(arm.flange(q) * tool), wanted = program.poses[k];
      return (stands.translation - wanted.translation).norm() / kMillimetre +
             (stands.rotation - wanted.rotation).norm() / kMilliradian;
    };
    before = std::max(before, distance(program.visits.q[k]));
    worst = std::max(worst, distance(targets[k].q));
  }
  EXPECT_GT(before, 0.5);
  EXPECT_LT(worst, 0.02);
}

// Calibrated, the arm goes back into its description, and so does a file that an earlier version
// made, whose last frame has the axis and the zero of the joint and whose tool has the rest.
TEST_P(MakersFlange, GoesBackIntoTheDescription) {
  const Maker& maker = GetParam();
  std::mt19937_64 random(6);
  const std::vector<Joint> joints = joints_of(maker);
  const std::string urdf = urdf_of(maker.name, joints);
  const Robot nominal = through_yaml(parse_urdf(urdf, maker.name, maker.ends));
  EXPECT_EQ(write_into_urdf(nominal, urdf, maker.name, maker.ends, {}).text, urdf);

  Robot robot = nominal;
  for (size_t j = 1; j < 5; ++j) {
    robot.chain.links[j].theta += 0.001;
    robot.chain.links[j].r += 0.0003;
  }
  Robot earlier = robot;
  KinematicChain& chain = earlier.chain;
  const double turn = 2.5, slide = -0.06;
  KinematicChain last;
  last.links = {chain.links[6]};
  const Pose rest = ChainEvaluator(last).pose(JointVector());
  chain.links[5].theta += turn;
  chain.links[5].r += slide;
  const Pose moved{Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                   slide * Eigen::Vector3d::UnitZ()};
  chain.tool = inverse(moved) * rest;
  Link zeros;
  zeros.name = chain.links[6].name;
  zeros.joint = JointKind::fixed;
  chain.links[6] = zeros;
  for (const bool keep_tool : {true, false})
    for (const Robot* own : {&robot, &earlier}) {
      const std::string text =
          write_into_urdf(*own, urdf, maker.name, maker.ends, {false, keep_tool}).text;
      const Arm patched(text, maker.ends);
      for (int k = 0; k < 20; ++k) {
        const JointVector q = random_joints(random);
        const Pose found = pose_of(patched.flange(q)),
                   expected = ChainEvaluator(robot.chain).pose(q);
        EXPECT_LT((found.translation - expected.translation).norm(), 1e-8);
        EXPECT_LT((found.rotation - expected.rotation).norm(), 1e-8);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(All, MakersFlange, testing::ValuesIn(kMakers),
                         [](const auto& info) { return info.param.name; });

const Maker& maker_of(const std::string& name) {
  return *std::ranges::find(kMakers, name, &Maker::name);
}

// Turns that cancel each other are none of the flange.
TEST(Flange, OfAUniversalRobotsArmIsTheLastLinkAsItStands) {
  const Maker& maker = maker_of("universal_robots");
  const Robot robot = parse_urdf(urdf_of("ur", joints_of(maker)), "ur", maker.ends);
  const Link &joint_6 = robot.chain.links[5], &flange = robot.chain.links[6];
  EXPECT_NEAR(joint_6.r, 0.098, 1e-9);
  for (const double value : {flange.alpha, flange.d, flange.theta, flange.r, flange.beta})
    EXPECT_NEAR(value, 0, 1e-8);
}

TEST(Flange, Tool0IsNamedWhereTheTipStandsElsewhere) {
  const std::string kuka = urdf_of("kuka", joints_of(maker_of("kuka")));
  EXPECT_EQ(tool0_beside_tip(kuka, "r", {"base", "link_6"}), "tool0");
  EXPECT_EQ(tool0_beside_tip(kuka, "r", {"base", "flange"}), "tool0");
  EXPECT_EQ(tool0_beside_tip(kuka, "r", {"base", "tool0"}), "");
  const std::string staubli = urdf_of("staubli", joints_of(maker_of("staubli")));
  EXPECT_EQ(tool0_beside_tip(staubli, "r", {"base", "link_6"}), "");
  const std::string denso = urdf_of("denso", joints_of(maker_of("denso")));
  EXPECT_EQ(tool0_beside_tip(denso, "r", {"base_link", "J6"}), "");
}

// A foot beside axis 1 cannot be that of link 1.
TEST(Flange, AFootThatStandsBesideTheBaseIsSaid) {
  std::string joints = maker_of("denso").joints;
  joints.replace(joints.find("0 0 0.1815"), 10, "0.2 0.3 0.18");
  const Maker moved{"moved", joints, {"base_link", "J6"}};
  const std::string urdf = urdf_of("moved", joints_of(moved));
  EXPECT_LT((foot_beside_base(urdf, "r", moved.ends) - Eigen::Vector3d(0, 0.3, 0)).norm(), 1e-12);
}

// The last link and the tool of a document that convert-robot wrote stay two things where somebody
// changes an origin.
TEST(Flange, OfAnOwnDocumentStaysTheLastLink) {
  const Maker& maker = maker_of("kuka");
  Robot robot = parse_urdf(urdf_of("kuka", joints_of(maker)), "kuka", maker.ends);
  robot.chain.tool.translation = {0.01, 0.02, 0.15};
  robot.chain.base.translation = {1, 2, 3};
  std::string text = write_urdf(robot);
  const size_t place = text.find("xyz=\"0.4", text.find("joint_link_3")) + 5;
  ASSERT_NEAR(std::stod(text.substr(place)), 0.462, 1e-12) << text;
  text.replace(place, text.find(' ', place) - place, "0.463");
  const Robot back = parse_urdf(text, "r");
  EXPECT_NEAR(back.chain.links[2].d, 0.463, 1e-9);
  EXPECT_LT((back.chain.tool.translation - robot.chain.tool.translation).norm(), 1e-12);
  EXPECT_LT((back.chain.base.translation - robot.chain.base.translation).norm(), 1e-9);
}

}  // namespace
}  // namespace armtrue::flange_test
