// Chains of 1 to 10 joints, revolute and prismatic in any order, with fixed links between.

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <string>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/joint_names.h"
#include "kinematics/kdl_arm.h"
#include "support/autodiff_chain.h"
#include "support/random_chain.h"

namespace armtrue::any_chain_test {
namespace {

using armtrue_oracle::Uniform;

char letter(const Link& link) {
  return link.joint == JointKind::revolute ? 'R' : is_prismatic(link) ? 'P' : 'F';
}

std::string letters(const KinematicChain& chain) {
  std::string text;
  for (const Link& link : chain.links) text += letter(link);
  return text;
}

void draw_pose(Uniform& uniform, Pose& pose) {
  pose.rotation = rotation_exp({uniform(-2, 2), uniform(-1, 1), uniform(-1, 1)});
  pose.translation = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
}

// `joints` driven links of either kind, a third of them behind a fixed one.
KinematicChain random_chain(Uniform& uniform, int joints, bool with_beta) {
  KinematicChain chain;
  const auto add = [&](JointKind kind) {
    Link link;
    link.name = "L" + std::to_string(chain.links.size() + 1);
    link.joint = kind;
    link.alpha = uniform(-3, 3);
    link.d = uniform(-1, 1);
    link.theta = uniform(-3, 3);
    link.r = uniform(-1, 1);
    link.beta = with_beta ? uniform(-0.3, 0.3) : 0;
    link.sign = uniform(0, 1) < 0.5 ? -1 : 1;
    chain.links.push_back(link);
  };
  for (int j = 0; j < joints; ++j) {
    if (uniform(0, 1) < 0.33) add(JointKind::fixed);
    add(uniform(0, 1) < 0.35 ? JointKind::prismatic : JointKind::revolute);
  }
  if (uniform(0, 1) < 0.5) add(JointKind::fixed);
  chain.links.resize(std::min<size_t>(chain.links.size(), kMaxLinks));
  draw_pose(uniform, chain.base);
  draw_pose(uniform, chain.tool);
  return chain;
}

JointVector random_values(Uniform& uniform, const KinematicChain& chain) {
  JointVector q(joint_count(chain));
  for (double& value : q) value = uniform(-1.5, 1.5);
  return q;
}

// The way from R_A through KDL's own frames and joints.
KDL::Chain kdl_chain(const KinematicChain& chain) {
  KDL::Chain arm;
  arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.base)));
  for (const Link& link : chain.links) {
    const KDL::Frame frame = KDL::Frame::DH_Craig1989(link.d, link.alpha, link.r, link.theta);
    arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), frame));
    if (link.joint == JointKind::fixed) continue;
    const auto axis = is_prismatic(link) ? KDL::Joint::TransZ : KDL::Joint::RotZ;
    arm.addSegment(KDL::Segment(KDL::Joint(axis, link.sign)));
  }
  arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.tool)));
  return arm;
}

class AnyChain : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(OfJoints, AnyChain, testing::Range(1, kMaxJoints + 1));

TEST_P(AnyChain, EqualsKdl) {
  Uniform uniform(200 + GetParam());
  for (int i = 0; i < 30; ++i) {
    const KinematicChain chain = random_chain(uniform, GetParam(), false);
    const JointVector q = random_values(uniform, chain);
    const KDL::Chain arm = kdl_chain(chain);
    ASSERT_EQ(arm.getNrOfJoints(), q.size());
    KDL::JntArray values(static_cast<unsigned>(q.size()));
    values.data = q;
    KDL::Frame expected;
    KDL::ChainFkSolverPos_recursive(arm).JntToCart(values, expected);
    const Pose own = ChainEvaluator(chain).pose(q);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(own.translation[row], expected.p(row), 1e-12) << letters(chain);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(own.rotation(row, c), expected.M(row, c), 1e-12);
    }
    // The frames of the links lead to the same place.
    const LinkFrames frames = ChainEvaluator(chain).link_frames(q);
    ASSERT_EQ(frames.size(), chain.links.size());
    const Pose end = chain.base * frames.back() * chain.tool;
    EXPECT_LT((end.translation - own.translation).norm(), 1e-12);
  }
}

constexpr int kMostParameters = kMaxGeometricParameters;
using Jet = ceres::Jet<double, kMostParameters>;

TEST_P(AnyChain, JacobianEqualsAutodiff) {
  Uniform uniform(300 + GetParam());
  for (int i = 0; i < 8; ++i) {
    const KinematicChain chain = random_chain(uniform, GetParam(), true);
    const JointVector q = random_values(uniform, chain);
    const int parameters = layout_of(chain).geometric;
    std::vector<Jet> p;
    for (int k = 0; k < parameters; ++k) p.emplace_back(0.0, k);
    std::vector<double> sign;
    for (int j = 0; j < link_count(chain); ++j) {
      const Link& link = chain.links[static_cast<size_t>(j)];
      const double values[] = {link.alpha, link.d, link.theta, link.r, link.beta};
      for (int k = 0; k < 5; ++k)
        p[static_cast<size_t>(link_parameter(j, LinkParameter::alpha) + k)].a = values[k];
      if (link.joint != JointKind::fixed) sign.push_back(link.sign);
    }
    const auto matrix = [](const Pose& pose) {
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      m.topLeftCorner<3, 3>() = pose.rotation;
      m.topRightCorner<3, 1>() = pose.translation;
      return m;
    };
    const auto frame = armtrue_oracle::chain<Jet>(
        p.data(), q.data(), sign.data(), matrix(chain.base), matrix(chain.tool), letters(chain));
    PoseJacobian own;
    ChainEvaluator(chain).pose(q, own);
    ASSERT_EQ(own.cols(), parameters);
    for (int k = 0; k < parameters; ++k) {
      Eigen::Matrix<double, 6, 1> expected;
      Eigen::Matrix3d r, dr;
      for (int row = 0; row < 3; ++row) {
        expected[row] = frame(row, 3).v[k];
        for (int c = 0; c < 3; ++c) {
          r(row, c) = frame(row, c).a;
          dr(row, c) = frame(row, c).v[k];
        }
      }
      const Eigen::Matrix3d spin = dr * r.transpose();
      expected.tail<3>() << spin(2, 1), spin(0, 2), spin(1, 0);
      EXPECT_LT((own.col(k) - expected).norm(), 1e-9 * (expected.norm() + 1e-3))
          << letters(chain) << ", column " << parameter_name(chain, k);
    }
  }
}

// What an encoder adds is what its zero offset adds, with the encoder's sign.
TEST_P(AnyChain, EncodersMoveTheirZeroOffsets) {
  Uniform uniform(400 + GetParam());
  const KinematicChain chain = random_chain(uniform, GetParam(), true);
  const JointVector q = random_values(uniform, chain);
  for (int j = 0; j < joint_count(chain); ++j) {
    JointVector moved = q;
    moved[j] += 0.25;
    KinematicChain other = chain;
    EXPECT_TRUE(is_zero_offset(chain, zero_offset(chain, j)));
    EXPECT_EQ(joint_of_link(chain, link_of_joint(chain, j)), j);
    move_parameter(other, zero_offset(chain, j), 0.25 * joint_link(chain, j).sign);
    const Pose a = ChainEvaluator(chain).pose(moved), b = ChainEvaluator(other).pose(q);
    EXPECT_LT((a.translation - b.translation).norm() + (a.rotation - b.rotation).norm(), 1e-13);
  }
}

// From a start close by, the pose is reached and, of a redundant arm, no farther away than where it
// was taken.
TEST_P(AnyChain, InverseKinematicsStaysNearItsStart) {
  Uniform uniform(500 + GetParam());
  for (int i = 0; i < 20; ++i) {
    const KinematicChain chain = random_chain(uniform, GetParam(), true);
    const JointVector q = random_values(uniform, chain);
    JointVector start = q;
    for (double& value : start) value += uniform(-0.02, 0.02);
    const InverseResult found = inverse_kinematics(chain, ChainEvaluator(chain).pose(q), start);
    const Pose wanted = ChainEvaluator(chain).pose(q),
               reached = ChainEvaluator(chain).pose(found.q);
    EXPECT_TRUE(found.reached) << letters(chain) << " " << found.position_error;
    EXPECT_LT((wanted.translation - reached.translation).norm(), 1e-10);
    if (GetParam() > 6) EXPECT_LT((found.q - start).norm(), 1.1 * (q - start).norm() + 1e-3);
  }
}

TEST(Chains, ParametersAreNamedAndFoundInTheirOrder) {
  Uniform uniform(600);
  KinematicChain chain = random_chain(uniform, 7, true);
  chain.targets = {{"1", {}}};
  chain.anchors = {{"wire", {}, 0}};
  for (int k = 0; k < parameter_count(chain); ++k)
    EXPECT_EQ(find_parameter(chain, parameter_name(chain, k)), k);
  EXPECT_EQ(find_parameter(chain, "tool.x"), 6 + 5 * link_count(chain));
  EXPECT_EQ(find_parameter(chain, "target 1.x"), layout_of(chain).targets);
}

TEST(JointNames, ExternalAxesHaveNumbersOfTheirOwn) {
  KinematicChain chain;
  for (const char* name : {"E1", "A1", "A2", "E2", "plate", "A3"}) {
    Link& link = chain.links.emplace_back();
    link.name = name;
    if (link.name == "E1") link.joint = JointKind::prismatic;
    if (link.name == "plate") link.joint = JointKind::fixed;
  }
  std::vector<std::string> columns;
  for (const JointName& joint : joint_names(chain)) columns.push_back(joint.encoder());
  EXPECT_EQ(columns, (std::vector<std::string>{"e1_mm", "q1_deg", "q2_deg", "e2_deg", "q3_deg"}));
  EXPECT_EQ(encoder_columns(chain), "e1_mm, q1_deg to q2_deg, e2_deg, q3_deg");
}

TEST(Chains, ThatIsTooLongIsRefused) {
  KinematicChain chain;
  chain.links.resize(kMaxJoints + 1);
  EXPECT_THROW(ChainEvaluator{chain}, std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::any_chain_test
