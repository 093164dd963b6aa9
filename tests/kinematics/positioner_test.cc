// A positioner that carries the part: the chain from the part to the tool against KDL, which goes
// the way that the maker's table goes, from the foot of the positioner to the part, and from the
// foot of the arm to the tool.

#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <numbers>
#include <string>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/conventions.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_names.h"
#include "kinematics/kdl_arm.h"
#include "support/random_chain.h"

namespace armtrue::positioner_test {
namespace {

using armtrue_oracle::Uniform;

Pose random_pose(Uniform& uniform) {
  return {rotation_exp({uniform(-2, 2), uniform(-1, 1), uniform(-1, 1)}),
          {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}};
}

KinematicChain random_chain(Uniform& uniform, const std::string& name, int joints) {
  KinematicChain chain;
  for (int j = 0; j < joints; ++j) {
    Link link;
    link.name = name + std::to_string(j + 1);
    link.joint = uniform(0, 1) < 0.25 ? JointKind::prismatic : JointKind::revolute;
    link.alpha = uniform(-3, 3);
    link.d = uniform(-1, 1);
    link.theta = uniform(-3, 3);
    link.r = uniform(-1, 1);
    link.sign = uniform(0, 1) < 0.5 ? -1 : 1;
    chain.links.push_back(link);
  }
  chain.base = random_pose(uniform);
  chain.tool = random_pose(uniform);
  return chain;
}

KDL::Chain by_kdl(const KinematicChain& chain) {
  KDL::Chain result;
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.base)));
  for (const Link& link : chain.links) {
    result.addSegment(
        KDL::Segment(KDL::Joint(KDL::Joint::None),
                     KDL::Frame::DH_Craig1989(link.d, link.alpha, link.r, link.theta)));
    const auto axis = is_prismatic(link) ? KDL::Joint::TransZ : KDL::Joint::RotZ;
    result.addSegment(KDL::Segment(KDL::Joint(axis, link.sign)));
  }
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.tool)));
  return result;
}

KDL::Frame end_of(const KDL::Chain& chain, const Eigen::VectorXd& q) {
  KDL::JntArray values(static_cast<unsigned>(q.size()));
  values.data = q;
  KDL::Frame frame;
  KDL::ChainFkSolverPos_recursive(chain).JntToCart(values, frame);
  return frame;
}

void expect_equal(const Pose& own, const KDL::Frame& expected) {
  for (int row = 0; row < 3; ++row) {
    EXPECT_NEAR(own.translation[row], expected.p(row), 1e-12);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(own.rotation(row, c), expected.M(row, c), 1e-12);
  }
}

KinematicChain from_part(const KinematicChain& positioner, const KinematicChain& arm) {
  const PartToFoot way = part_to_foot(positioner, arm.base);
  KinematicChain chain = arm;
  chain.base = way.base;
  chain.links.insert(chain.links.begin(), way.links.begin(), way.links.end());
  return chain;
}

// The encoder values of the chain: those of the positioner come in reverse order.
JointVector joined(const Eigen::VectorXd& positioner, const Eigen::VectorXd& arm) {
  JointVector q(positioner.size() + arm.size());
  q << positioner.reverse(), arm;
  return q;
}

TEST(Positioner, PoseAndJacobianEqualKdl) {
  Uniform uniform(51);
  for (int i = 0; i < 60; ++i) {
    const KinematicChain positioner = random_chain(uniform, "E", 1 + i % 3);
    const KinematicChain arm = random_chain(uniform, "A", 6);
    Eigen::VectorXd e(positioner.links.size()), a(6);
    for (double& value : e) value = uniform(-1.5, 1.5);
    for (double& value : a) value = uniform(-1.5, 1.5);
    const KinematicChain chain = from_part(positioner, arm);
    PoseJacobian jacobian;
    const Pose own = ChainEvaluator(chain).pose(joined(e, a), jacobian);
    const KDL::Chain kdl_positioner = by_kdl(positioner), kdl_arm = by_kdl(arm);
    const KDL::Frame part = end_of(kdl_positioner, e), tool = end_of(kdl_arm, a);
    expect_equal(own, part.Inverse() * tool);

    // What the positioner does to the tool, seen from the part, is the reverse of what it does to a
    // point of the part that is where the tool is.
    KDL::JntArray values(static_cast<unsigned>(e.size()));
    values.data = e;
    KDL::Jacobian of_part(static_cast<unsigned>(e.size()));
    KDL::ChainJntToJacSolver(kdl_positioner).JntToJac(values, of_part);
    of_part.changeRefPoint(tool.p - part.p);
    of_part.changeBase(part.M.Inverse());
    for (int j = 0; j < static_cast<int>(e.size()); ++j) {
      const auto column = joint_column(chain, jacobian, static_cast<int>(e.size()) - 1 - j);
      for (int row = 0; row < 6; ++row)
        EXPECT_NEAR(column[row], -of_part(static_cast<unsigned>(row), static_cast<unsigned>(j)),
                    1e-12);
    }
  }
}

// Axes of the table and the arm that are parallel or the same have no one common normal.
TEST(Positioner, MayStandParallelToTheArm) {
  Uniform uniform(52);
  const KinematicChain arm = random_chain(uniform, "A", 6);
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d hanging = rotation_from_abc(0.7, 0, std::numbers::pi);
  for (const Pose& between : {Pose{}, Pose{upright, {0, 0, 0.4}}, Pose{upright, {1.5, -0.3, 0.2}},
                              Pose{hanging, {1.5, -0.3, 0.2}}}) {
    KinematicChain table = random_chain(uniform, "E", 1);
    table.links[0].alpha = table.links[0].d = 0;
    table.base = arm.base * between;
    const Eigen::VectorXd e = Eigen::VectorXd::Constant(1, 0.6);
    const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(6, -1, 1);
    expect_equal(ChainEvaluator(from_part(table, arm)).pose(joined(e, a)),
                 end_of(by_kdl(table), e).Inverse() * end_of(by_kdl(arm), a));
  }
}

TEST(Positioner, StarterIsItsTable) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-dkp400.yaml").robot;
  ASSERT_TRUE(robot.ground_link);
  EXPECT_EQ(encoder_columns(robot.chain), "e2_deg, e1_deg, q1_deg to q6_deg");
  // By hand: the table stands 347 mm above the tilt axis, 857 mm high, and is level.
  const LinkFrames frames = ChainEvaluator(robot.chain).link_frames(JointVector::Zero(8));
  const Pose foot_from_part =
      inverse(robot.chain.base * frames[static_cast<size_t>(*robot.ground_link)]);
  EXPECT_LT((foot_from_part.translation - Eigen::Vector3d(2.1, 0, 0.857)).norm(), 1e-12);
  EXPECT_NEAR(foot_from_part.rotation(2, 2), 1, 1e-12);
  // E1 tilts the table about the y axis of the foot: by 90 deg the table faces the arm or not.
  JointVector tilted = JointVector::Zero(8);
  tilted[1] = std::numbers::pi / 2;
  const LinkFrames after = ChainEvaluator(robot.chain).link_frames(tilted);
  const Pose tilted_part =
      inverse(robot.chain.base * after[static_cast<size_t>(*robot.ground_link)]);
  EXPECT_NEAR(std::abs(tilted_part.rotation(0, 2)), 1, 1e-12);
  EXPECT_NEAR(tilted_part.translation.z(), 0.51, 1e-12);
}

TEST(Positioner, ComesBackFromItsFile) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-dkp400.yaml").robot;
  const Robot again = parse_robot(write_robot(robot), "again.yaml");
  EXPECT_EQ(again.ground_link, robot.ground_link);
  EXPECT_EQ(write_robot(again), write_robot(robot));
  EXPECT_EQ(again.bodies.front().link, *robot.ground_link + 1);
}

}  // namespace
}  // namespace armtrue::positioner_test
