// Two arms of one URDF as one chain, from the tool of the left one back to its foot and on to the
// tool of the right one: by urdfdom and KDL, which share no code with armtrue.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/io/campaign_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/text/input_error.h"
#include "armtrue/urdf/urdf_io.h"
#include "support/temporary_file.h"
#include "urdf/urdf_distance.h"

namespace armtrue::two_arms_test {
namespace {

using Eigen::Vector3d;
using oracle::UrdfArm;

const UrdfEnds kTools{"left_tool", "right_tool"};

// Normal numbers of a deviation; without a size, zeros.
class Errors {
 public:
  explicit Errors(double size = 0, unsigned seed = 1) : size_(size), engine_(seed) {}
  double next() { return size_ * normal_(engine_); }

 private:
  double size_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

struct Joint {
  std::string type, xyz, axis;
};

const std::vector<Joint> kSixJoints{
    {"revolute", "0 0 0.3", "0 0 1"},  {"revolute", "0.1 0 0.2", "0 1 0"},
    {"revolute", "0 0 0.6", "0 1 0"},  {"revolute", "0.2 0 0.1", "1 0 0"},
    {"revolute", "0.4 0 0", "0 -1 0"}, {"revolute", "0.1 0 0", "1 0 0"}};
const std::vector<Joint> kSevenJoints{
    {"revolute", "0 0 0.3", "0 0 1"},      {"revolute", "0.02 0 0.1", "0 1 0"},
    {"revolute", "0 0.01 0.3", "0 0 1"},   {"revolute", "0.05 0 0.2", "0 -1 0"},
    {"revolute", "-0.05 0 0.25", "0 0 1"}, {"prismatic", "0 0.03 0.1", "0 1 0.3"},
    {"revolute", "0.08 0 0.1", "1 0 0.2"}};

// Each number of an origin is off by the next error [m or rad].
std::string two_arms(const std::vector<Joint>& joints, Errors& errors) {
  std::string text = "<robot name=\"pair\"><link name=\"world\"/><link name=\"stand\"/>\n";
  const auto joint = [&](const std::string& name, const std::string& parent,
                         const std::string& child, const Joint& of, const Vector3d& rpy) {
    Vector3d xyz;
    std::sscanf(of.xyz.c_str(), "%lf %lf %lf", &xyz[0], &xyz[1], &xyz[2]);
    for (double& value : xyz) value += errors.next();
    Vector3d turned = rpy;
    for (double& value : turned) value += errors.next();
    text += fmt::format(
        "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>"
        "<origin xyz=\"{:.17g} {:.17g} {:.17g}\" rpy=\"{:.17g} {:.17g} {:.17g}\"/>"
        "<axis xyz=\"{}\"/><limit lower=\"-2\" upper=\"{}\" effort=\"1\" "
        "velocity=\"1\"/></joint>\n",
        name, of.type, parent, child, xyz[0], xyz[1], xyz[2], turned[0], turned[1], turned[2],
        of.axis, of.type == "prismatic" ? "1" : "2.5");
  };
  joint("to_stand", "world", "stand", {"fixed", "0.1 0.2 0.8", "0 0 1"}, {0, 0, 0});
  for (const std::string side : {"left", "right"}) {
    const bool left = side == "left";
    text += fmt::format("<link name=\"{}_tool\"/>", side);
    std::string before = "stand";
    for (size_t j = 0; j < joints.size(); ++j) {
      const std::string link = fmt::format("{}_link{}", side, j + 1);
      text += fmt::format(
          "<link name=\"{}\"><inertial><origin xyz=\"0 0 0.1\"/><mass value=\"3\"/>"
          "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"
          "</inertial></link>",
          link);
      Joint own = joints[j];
      if (j == 0) own.xyz = left ? "0 0.4 0.3" : "0 -0.4 0.3";
      const Vector3d mount = left ? Vector3d(-0.5, 0.1, 0.2) : Vector3d(0.5, 0, -0.3);
      joint(fmt::format("{}_joint{}", side, j + 1), before, link, own,
            j == 0 ? mount : Vector3d(0, 0, 0));
      before = link;
    }
    joint(side + "_flange", before, side + "_tool", {"fixed", "0.15 0 0.05", "0 0 1"}, {0, 0.3, 0});
  }
  return text + "</robot>\n";
}

std::string nominal_text(const std::vector<Joint>& joints) {
  Errors none;
  return two_arms(joints, none);
}

Robot nominal_pair(const std::vector<Joint>& joints) {
  return parse_urdf(nominal_text(joints), "pair.urdf", kTools);
}

TEST(TwoArms, AreTheChainFromToolToTool) {
  for (const std::vector<Joint>& joints : {kSixJoints, kSevenJoints}) {
    for (unsigned seed : {1, 2, 3}) {
      Errors skew(seed == 1 ? 0 : 0.1, seed);
      const std::string text = two_arms(joints, skew);
      const Robot robot = parse_urdf(text, "pair.urdf", kTools);
      ASSERT_EQ(joint_count(robot.chain), 2 * std::ssize(joints));
      const UrdfArm arm(text, kTools.base, kTools.tip);
      const Distance apart = distance_between(arm, robot.chain);
      EXPECT_LT(apart.place, 1e-9);
      EXPECT_LT(apart.attitude, 1e-9);
    }
  }
}

// The joints of the left arm come first, its last one before all others; each link has the name of
// the link that its joint moves in the document, and the other arm has masses.
TEST(TwoArms, KeepTheirNamesAndStandOnTheGround) {
  const Robot robot = nominal_pair(kSixJoints);
  std::vector<std::string> names;
  for (const Link& link : robot.chain.links) names.push_back(link.name);
  EXPECT_THAT(names, testing::ElementsAre("left_link6", "left_link5", "left_link4", "left_link3",
                                          "left_link2", "left_link1", "stand", "right_link1",
                                          "right_link2", "right_link3", "right_link4",
                                          "right_link5", "right_link6", "flange"));
  ASSERT_TRUE(robot.ground_link);
  EXPECT_EQ(*robot.ground_link, 6);
  for (const Body& body : robot.bodies) EXPECT_GT(body.link, 6);
  EXPECT_EQ(robot.bodies.size(), 6u);
  // Gravity is that of the stand, whose axes the frame of the ground has.
  const JointVector q = JointVector::Constant(12, 0.3);
  const Pose ground = ChainEvaluator(robot.chain).link_frames(q)[6];
  const KDL::Frame stand =
      UrdfArm(nominal_text(kSixJoints), "left_tool", "stand").pose(std::vector<double>(6, 0.3));
  const Pose in_base = robot.chain.base * ground;
  for (int row = 0; row < 3; ++row) EXPECT_NEAR(in_base.rotation(row, 2), stand.M(row, 2), 1e-12);
  const std::string yaml = write_robot(robot);
  EXPECT_EQ(write_robot(parse_robot(yaml, "pair.yaml")), yaml);
}

TEST(TwoArms, AWayThatOnlyLeadsBackIsNoArm) {
  const std::string text = nominal_text(kSixJoints);
  for (const char* tip : {"stand", "left_link2"})
    EXPECT_THROW(parse_urdf(text, "pair.urdf", {"left_tool", tip}), InputError);
  EXPECT_THROW(write_into_urdf(nominal_pair(kSixJoints), text, "pair.urdf", kTools, {}),
               InputError);
}

Vector3d place(const UrdfArm& arm, const Eigen::VectorXd& q) {
  const KDL::Frame frame = arm.pose({q.begin(), q.end()});
  return {frame.p.x(), frame.p.y(), frame.p.z()};
}

class Truth {
 public:
  Truth(const std::vector<Joint>& joints, Errors errors, unsigned seed)
      : arm_(two_arms(joints, errors), kTools.base, kTools.tip), random_(seed) {}

  Eigen::VectorXd drawn() {
    const std::vector<double> q = random_joints(arm_, random_);
    return 0.6 * Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q));
  }
  Vector3d point(const Eigen::VectorXd& q) const { return place(arm_, q); }
  Vector3d noise(double size) {
    return size * Vector3d(normal_(random_), normal_(random_), normal_(random_));
  }

  // A posture in which the right tool is at `wanted` of the left one.
  Eigen::VectorXd touching(const Vector3d& wanted) {
    constexpr double kStep = 1e-6, kDamping = 1e-4, kLongest = 0.3, kTravel = 1.9;
    for (;;) {
      Eigen::VectorXd q = drawn();
      for (int k = 0; k < 60; ++k) {
        const Vector3d here = point(q), miss = wanted - here;
        if (miss.norm() < 1e-10 && q.cwiseAbs().maxCoeff() < kTravel) return q;
        Eigen::Matrix3Xd jacobian(3, q.size());
        for (Eigen::Index j = 0; j < q.size(); ++j) {
          Eigen::VectorXd moved = q;
          moved[j] += kStep;
          jacobian.col(j) = (point(moved) - here) / kStep;
        }
        const Eigen::Matrix3d normal =
            jacobian * jacobian.transpose() +
            std::min(kDamping, miss.norm()) * Eigen::Matrix3d::Identity();
        const Eigen::VectorXd step = jacobian.transpose() * normal.inverse() * miss;
        q += step * std::min(1.0, kLongest / step.cwiseAbs().maxCoeff());
      }
    }
  }

 private:
  UrdfArm arm_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

struct Reading {
  Eigen::VectorXd q;
  std::string cells;  // behind the joints
};

Campaign campaign_of(const std::vector<Reading>& readings, const std::string& columns,
                     const Robot& robot) {
  const std::vector<JointName> joints = joint_names(robot.chain);
  std::string text = "pose";
  for (const JointName& joint : joints) text += "," + joint.encoder();
  text += "," + columns + "\n";
  for (size_t i = 0; i < readings.size(); ++i) {
    text += std::to_string(i + 1);
    for (size_t j = 0; j < joints.size(); ++j)
      text += fmt::format(",{:.12g}", readings[i].q[static_cast<Eigen::Index>(j)] / joints[j].si());
    text += "," + readings[i].cells + "\n";
  }
  Campaign campaign = read_campaign(TemporaryFile(text).path, joints).campaign;
  if (columns == "contact") bind_touches(campaign, robot.chain);
  return campaign;
}

// A tracker on the left tool that sees the right one.
Campaign tracked(Truth& truth, int poses, double noise, const Robot& robot) {
  std::vector<Reading> readings;
  for (int i = 0; i < poses; ++i) {
    const Eigen::VectorXd q = truth.drawn();
    const Vector3d p = (truth.point(q) + truth.noise(noise)) / kMillimetre;
    readings.push_back({q, fmt::format("{:.10g},{:.10g},{:.10g}", p.x(), p.y(), p.z())});
  }
  return campaign_of(readings, "x_mm,y_mm,z_mm", robot);
}

// RMS distance on fresh poses of the right tool seen from the left one, beside a motion of all
// points and, with `scale`, an enlargement, which touches do not show [m].
double left_of(const KinematicChain& fitted, Truth& truth, bool scale) {
  constexpr int kFresh = 200;
  const ChainEvaluator evaluator(fitted);
  Eigen::Matrix3Xd model(3, kFresh), exact(3, kFresh);
  for (int i = 0; i < kFresh; ++i) {
    const Eigen::VectorXd q = truth.drawn();
    model.col(i) = evaluator.pose(JointVector(q)).translation;
    exact.col(i) = truth.point(q);
  }
  const Eigen::Matrix4d moved = Eigen::umeyama(model, exact, scale);
  const Eigen::Matrix3Xd left =
      (moved.topLeftCorner<3, 3>() * model).colwise() + moved.topRightCorner<3, 1>() - exact;
  return std::sqrt(left.squaredNorm() / kFresh);
}

constexpr double kErrors = 3e-4, kNoise = 5e-5;  // m, rad

// Fourteen joints, one of them a slide on each arm.
TEST(TwoArms, OfFourteenJointsAreCalibratedByATracker) {
  Truth truth(kSevenJoints, Errors(kErrors, 7), 11);
  Robot robot = nominal_pair(kSevenJoints);
  robot.noise.position = kNoise;
  const double before = left_of(robot.chain, truth, false);
  const CalibrationResult fit = calibrate(robot, tracked(truth, 120, kNoise, robot));
  EXPECT_TRUE(fit.converged);
  const double after = left_of(fit.robot.chain, truth, false);
  std::printf("fourteen joints: %.3f mm before, %.3f mm after\n", 1e3 * before, 1e3 * after);
  EXPECT_GT(before, 5e-4);
  EXPECT_LT(after, kNoise * std::sqrt(3.0));
}

// A ball at the right tool in six sockets at the left one, whose places nobody knows, or know
// relative to each other (a plate): over the whole travel the relative place of the tools is as
// good as by a tracker.
TEST(TwoArms, ThatTouchAreAsGoodAsByATracker) {
  constexpr int kCampaigns = 8, kPoses = 80;
  const Vector3d sockets[] = {{0.5, 0.3, 0.1},  {0.1, -0.5, 0.2}, {-0.4, 0.1, 0.4},
                              {0.4, -0.1, 0.7}, {0, 0.5, 0.6},    {-0.3, -0.4, -0.2}};
  double by_tracker = 0, by_sockets = 0, by_plate = 0;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    Truth truth(kSixJoints, Errors(kErrors, seed), 100 + seed);
    Robot robot = nominal_pair(kSixJoints);
    robot.noise.position = kNoise;
    Robot with_plate = robot, with_sockets = robot;
    Contact& plate = with_plate.chain.contacts.emplace_back();
    plate.name = "plate";
    plate.kind = ContactKind::artefact;
    plate.is_placed = false;
    for (size_t k = 0; k < std::size(sockets); ++k) {
      Contact& socket = with_sockets.chain.contacts.emplace_back();
      socket.name = fmt::format("s{}", k + 1);
      socket.is_placed = false;
      plate.points.push_back({socket.name, sockets[k] - sockets[0]});
    }
    std::vector<Reading> of_sockets, of_plate;
    for (size_t i = 0; i < kPoses; ++i) {
      const size_t k = i % std::size(sockets);
      const Eigen::VectorXd q = truth.touching(sockets[k] + truth.noise(kNoise));
      of_sockets.push_back({q, fmt::format("s{}", k + 1)});
      of_plate.push_back({q, fmt::format("plate/s{}", k + 1)});
    }
    const auto left = [&](const Robot& nominal, const Campaign& campaign, bool scale) {
      return std::pow(left_of(calibrate(nominal, campaign).robot.chain, truth, scale), 2);
    };
    by_tracker += left(robot, tracked(truth, kPoses, kNoise, robot), false);
    by_sockets += left(with_sockets, campaign_of(of_sockets, "contact", with_sockets), true);
    by_plate += left(with_plate, campaign_of(of_plate, "contact", with_plate), false);
  }
  std::printf("two arms: tracker %.4f mm, sockets %.2f of it beside the scale, plate %.2f of it\n",
              1e3 * std::sqrt(by_tracker / kCampaigns), std::sqrt(by_sockets / by_tracker),
              std::sqrt(by_plate / by_tracker));
  EXPECT_LT(std::sqrt(by_sockets / by_tracker), 2);
  EXPECT_LT(std::sqrt(by_plate / by_tracker), 2);
}

}  // namespace
}  // namespace armtrue::two_arms_test
