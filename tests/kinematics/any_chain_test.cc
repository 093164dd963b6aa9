// Chains of 1 to 16 joints, revolute and prismatic in any order, with fixed links between.

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/joint_names.h"
#include "kinematics/frame_derivative.h"
#include "kinematics/kdl_arm.h"
#include "kinematics/lanes.h"
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
    const auto frame =
        armtrue_oracle::chain<Jet>(p.data(), q.data(), sign.data(), homogeneous(chain.base),
                                   homogeneous(chain.tool), letters(chain));
    PoseJacobian own;
    ChainEvaluator(chain).pose(q, own);
    ASSERT_EQ(own.cols(), parameters);
    for (int k = 0; k < parameters; ++k) {
      const Eigen::Matrix<double, 6, 1> expected = twist_by(frame, k);
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

constexpr size_t kLanes = LaneJacobians::kCount;

// Several at once, in groups that do not fill the lanes: each is the pose of one within rounding,
// to the bit the same beside any others, with offsets of its own or without.
TEST_P(AnyChain, ManyPosesEqualThoseOfOne) {
  Uniform uniform(700 + GetParam());
  for (int i = 0; i < 5; ++i) {
    const KinematicChain chain = random_chain(uniform, GetParam(), true);
    const ChainEvaluator evaluator(chain);
    const int parameters = layout_of(chain).geometric;
    std::vector<JointVector> q;
    std::vector<ParameterOffsets> offsets;
    for (int k = 0; k < 11; ++k) {
      q.push_back(random_values(uniform, chain));
      offsets.push_back(ParameterOffsets::Zero(parameters));
      for (double& offset : offsets.back())
        if (uniform(0, 1) < 0.3) offset = uniform(-0.01, 0.01);
    }
    for (const bool moved : {false, true}) {
      const std::span<const ParameterOffsets> own(offsets.data(), moved ? offsets.size() : 0);
      std::vector<Pose> poses(q.size()), without_jacobian(q.size());
      std::vector<LaneJacobians> jacobians((q.size() + kLanes - 1) / kLanes);
      evaluator.poses(q, own, poses, jacobians);
      evaluator.poses(q, own, without_jacobian);
      for (size_t k = 0; k < q.size(); ++k) {
        PoseJacobian expected;
        LaneJacobians alone;
        const LaneJacobians::OfPose jacobian = jacobians[k / kLanes][k % kLanes];
        const Pose pose =
            moved ? evaluator.pose(q[k], offsets[k], expected) : evaluator.pose(q[k], expected);
        EXPECT_LT((poses[k].rotation - pose.rotation).cwiseAbs().maxCoeff(), 1e-14);
        EXPECT_LT((poses[k].translation - pose.translation).cwiseAbs().maxCoeff(), 3e-14);
        ASSERT_EQ(jacobian.cols(), parameters);
        EXPECT_LT((jacobian - expected).cwiseAbs().maxCoeff(), 3e-14) << letters(chain);
        EXPECT_EQ(poses[k].rotation, without_jacobian[k].rotation);
        Pose single;
        evaluator.poses(std::span(q).subspan(k, 1), own.empty() ? own : own.subspan(k, 1),
                        std::span(&single, 1), std::span(&alone, 1));
        EXPECT_EQ(single.translation, poses[k].translation);
        EXPECT_EQ(alone[0], jacobian);
      }
    }
  }
}

TEST(ManyPoses, WriteOnlyTheColumnsThatAreAskedFor) {
  Uniform uniform(800);
  const KinematicChain chain = random_chain(uniform, 6, true);
  const ChainEvaluator evaluator(chain);
  std::vector<JointVector> q(5, random_values(uniform, chain));
  std::vector<Pose> poses(5);
  std::vector<LaneJacobians> jacobians(2);
  for (LaneJacobians& four : jacobians) {
    four.set_columns(layout_of(chain).geometric);
    for (size_t lane = 0; lane < kLanes; ++lane) four[lane].setConstant(1234.0);
  }
  PoseJacobian expected;
  evaluator.pose(q.front(), expected);
  ColumnSet columns;
  columns.set(7).set(11);
  evaluator.poses(q, {}, poses, jacobians, columns);
  for (size_t pose = 0; pose < q.size(); ++pose) {
    const LaneJacobians::OfPose jacobian = jacobians[pose / kLanes][pose % kLanes];
    for (int k = 0; k < jacobian.cols(); ++k)
      if (columns[static_cast<size_t>(k)])
        EXPECT_LT((jacobian.col(k) - expected.col(k)).norm(), 1e-13);
      else
        EXPECT_TRUE((jacobian.col(k).array() == 1234.0).all());
  }
  EXPECT_THROW(evaluator.poses(q, {}, std::span(poses).first(4)), std::invalid_argument);
  EXPECT_THROW(evaluator.poses(q, {}, poses, std::span(jacobians).first(1)), std::invalid_argument);
}

// Against long double: small, near quarter turns, many turns, and beyond what is reduced here.
TEST(SineOfLanes, IsWithinOneUnitInTheLastPlace) {
  Uniform uniform(900);
  const auto apart = [](double own, long double exact) {
    const double nearest = std::abs(static_cast<double>(exact));
    return std::abs(static_cast<double>(static_cast<long double>(own) - exact)) /
           (std::nextafter(nearest, 2.0) - nearest);
  };
  for (const double range : {1e-9, 1e-3, 1.0, 7.0, 1e3, 8e5, 1e7}) {
    for (int i = 0; i < 20000; ++i) {
      Lanes angles(0.0);
      for (int lane = 0; lane < Lanes::kCount; ++lane) {
        angles[lane] = uniform(-range, range);
        if (i % 2 == 1)
          angles[lane] =
              std::round(angles[lane] / (std::numbers::pi / 2)) * (std::numbers::pi / 2) +
              (i % 4 == 1 ? 0 : 1e-9 * uniform(-1, 1));
      }
      const Turn<Lanes> turn = turn_by(angles);
      for (int lane = 0; lane < Lanes::kCount; ++lane) {
        const auto angle = static_cast<long double>(angles[lane]);
        ASSERT_LT(apart(turn.sine[lane], std::sin(angle)), 1.0) << angles[lane];
        ASSERT_LT(apart(turn.cosine[lane], std::cos(angle)), 1.0) << angles[lane];
      }
    }
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
