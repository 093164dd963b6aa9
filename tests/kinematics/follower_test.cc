// Joints that follow others: random chains with rods and screws between any of their joints,
// against KDL with the values of all joints written out, and against automatic derivatives.

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/inverse.h"
#include "armtrue/kinematics/joint_names.h"
#include "kinematics/frame_derivative.h"
#include "kinematics/kdl_arm.h"
#include "support/autodiff_chain.h"
#include "support/random_chain.h"

namespace armtrue::follower_test {
namespace {

using armtrue_oracle::Uniform;
using Jet = ceres::Jet<double, kMaxGeometricParameters>;

// Seven links that move, two of them without encoders, and a fixed one. Joints follow earlier and
// later ones, one that follows itself another, and one with an encoder too.
KinematicChain random_chain(Uniform& uniform, bool with_beta) {
  KinematicChain chain;
  for (int j = 0; j < 8; ++j) {
    Link link;
    link.name = "L" + std::to_string(j + 1);
    link.joint = j == 7                ? JointKind::fixed
                 : uniform(0, 1) < 0.3 ? JointKind::prismatic
                                       : JointKind::revolute;
    link.alpha = uniform(-3, 3);
    link.d = uniform(-1, 1);
    link.theta = uniform(-3, 3);
    link.r = uniform(-1, 1);
    link.beta = with_beta ? uniform(-0.3, 0.3) : 0;
    link.sign = uniform(0, 1) < 0.5 ? -1 : 1;
    chain.links.push_back(link);
  }
  chain.links[2].has_encoder = chain.links[4].has_encoder = false;
  for (const auto& [follower, followed] :
       {std::pair(6, 4), std::pair(4, 1), std::pair(4, 2), std::pair(2, 5), std::pair(3, 0)})
    chain.couplings.push_back(
        {follower, followed, uniform(-1.5, 1.5),
         zero_of(std::as_const(chain.links[static_cast<size_t>(followed)])) + uniform(-0.1, 0.1)});
  for (Pose* pose : {&chain.base, &chain.tool}) {
    pose->rotation = rotation_exp({uniform(-2, 2), uniform(-1, 1), uniform(-1, 1)});
    pose->translation = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
  }
  return chain;
}

JointVector random_values(Uniform& uniform, const KinematicChain& chain) {
  JointVector q(joint_count(chain));
  for (double& value : q) value = uniform(-1.5, 1.5);
  return q;
}

// What the joint of a link adds to `constants`, by the sentence in chain.h, from the leaves up.
template <typename Number>
Number motion(const KinematicChain& chain, const JointVector& q,
              const std::vector<Number>& constants, const std::vector<Number>& coefficients,
              int link) {
  const Link& own = chain.links[static_cast<size_t>(link)];
  Number value(0.0);
  if (own.has_encoder && own.joint != JointKind::fixed) {
    int joint = 0;
    for (int j = 0; j < link; ++j)
      joint += chain.links[static_cast<size_t>(j)].has_encoder &&
               chain.links[static_cast<size_t>(j)].joint != JointKind::fixed;
    value = Number(q[joint]);
  }
  for (size_t k = 0; k < chain.couplings.size(); ++k) {
    const Coupling& coupling = chain.couplings[k];
    if (coupling.follower != link) continue;
    const double sign = chain.links[static_cast<size_t>(coupling.followed)].sign;
    value +=
        coefficients[k] * (sign * (constants[static_cast<size_t>(coupling.followed)] +
                                   motion(chain, q, constants, coefficients, coupling.followed) -
                                   Number(coupling.from)));
  }
  return own.sign * value;
}

TEST(Followers, StandWhereKdlHasThemWithAllJointsWrittenOut) {
  Uniform uniform(31);
  for (int i = 0; i < 40; ++i) {
    const KinematicChain chain = random_chain(uniform, false);
    const JointVector q = random_values(uniform, chain);
    ASSERT_EQ(q.size(), 5);
    std::vector<double> constants, coefficients;
    for (const Link& link : chain.links) constants.push_back(zero_of(link));
    for (const Coupling& coupling : chain.couplings) coefficients.push_back(coupling.coefficient);
    KDL::Chain arm;
    arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.base)));
    KDL::JntArray values(7);
    for (int j = 0; j < link_count(chain); ++j) {
      const Link& link = chain.links[static_cast<size_t>(j)];
      const KDL::Frame frame = KDL::Frame::DH_Craig1989(link.d, link.alpha, link.r, link.theta);
      arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), frame));
      if (link.joint == JointKind::fixed) continue;
      arm.addSegment(
          KDL::Segment(KDL::Joint(is_prismatic(link) ? KDL::Joint::TransZ : KDL::Joint::RotZ)));
      values(static_cast<unsigned>(j)) = motion<double>(chain, q, constants, coefficients, j);
      EXPECT_NEAR(link.sign * joint_values(chain, q)[static_cast<size_t>(j)],
                  values(static_cast<unsigned>(j)), 1e-13);
    }
    arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), kdl_frame(chain.tool)));
    KDL::Frame expected;
    KDL::ChainFkSolverPos_recursive(arm).JntToCart(values, expected);
    const Pose own = ChainEvaluator(chain).pose(q);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(own.translation[row], expected.p(row), 1e-12);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(own.rotation(row, c), expected.M(row, c), 1e-12);
    }
    const Pose end = chain.base * ChainEvaluator(chain).link_frames(q).back() * chain.tool;
    EXPECT_LT((end.translation - own.translation).norm(), 1e-12);
  }
}

// By every parameter: lengths and angles, zeros, which move what follows as the rods do, and
// coefficients.
TEST(Followers, JacobianEqualsAutodiff) {
  Uniform uniform(32);
  for (int i = 0; i < 20; ++i) {
    const KinematicChain chain = random_chain(uniform, true);
    const JointVector q = random_values(uniform, chain);
    const ParameterLayout layout = layout_of(chain);
    ASSERT_EQ(layout.geometric, 12 + 5 * 8 + 5);
    std::vector<Jet> p, constants, coefficients;
    for (int k = 0; k < layout.geometric; ++k) p.emplace_back(0.0, k);
    for (int j = 0; j < link_count(chain); ++j) {
      const Link& link = chain.links[static_cast<size_t>(j)];
      const double values[] = {link.alpha, link.d, link.theta, link.r, link.beta};
      for (int k = 0; k < 5; ++k)
        p[static_cast<size_t>(link_parameter(j, LinkParameter::alpha) + k)].a = values[k];
      constants.push_back(p[static_cast<size_t>(zero_of_link(chain, j))]);
    }
    for (size_t k = 0; k < chain.couplings.size(); ++k) {
      Jet coefficient = p[static_cast<size_t>(layout.couplings) + k];
      coefficient.a = chain.couplings[k].coefficient;
      coefficients.push_back(coefficient);
    }
    for (int j = 0; j < link_count(chain); ++j)
      p[static_cast<size_t>(zero_of_link(chain, j))] +=
          motion(chain, q, constants, coefficients, j);
    const auto frame = armtrue_oracle::chain<Jet>(
        p.data(), nullptr, nullptr, homogeneous(chain.base), homogeneous(chain.tool), "FFFFFFFF");
    PoseJacobian own;
    ChainEvaluator(chain).pose(q, own);
    ASSERT_EQ(own.cols(), layout.geometric);
    for (int k = 0; k < layout.geometric; ++k) {
      const Eigen::Matrix<double, 6, 1> expected = twist_by(frame, k);
      EXPECT_LT((own.col(k) - expected).norm(), 1e-9 * (expected.norm() + 1e-3))
          << "column " << parameter_name(chain, k);
    }
    // What an encoder adds is what its zero offset adds, with all that follows.
    for (int j = 0; j < joint_count(chain); ++j) {
      JointVector moved = q;
      moved[j] += 1e-6;
      const Eigen::Vector3d expected = (ChainEvaluator(chain).pose(moved).translation -
                                        ChainEvaluator(chain).pose(q).translation) /
                                       1e-6;
      EXPECT_LT((joint_column(chain, own, j).head<3>() - expected).norm(), 1e-4);
    }
  }
}

// Several at once equal one at a time, offsets of coefficients included, and columns that are
// asked for alone have what their followers add.
TEST(Followers, ManyPosesEqualThoseOfOne) {
  Uniform uniform(33);
  for (int i = 0; i < 5; ++i) {
    const KinematicChain chain = random_chain(uniform, true);
    const ChainEvaluator evaluator(chain);
    const int parameters = layout_of(chain).geometric;
    std::vector<JointVector> q;
    std::vector<ParameterOffsets> offsets;
    for (int k = 0; k < 6; ++k) {
      q.push_back(random_values(uniform, chain));
      offsets.push_back(ParameterOffsets::Zero(parameters));
      for (double& offset : offsets.back()) offset = uniform(-0.01, 0.01);
    }
    std::vector<Pose> poses(q.size());
    std::vector<LaneJacobians> all(2), some(2);
    evaluator.poses(q, offsets, poses, all);
    ColumnSet columns;
    columns.set(static_cast<size_t>(zero_offset(chain, 0)));
    columns.set(static_cast<size_t>(zero_of_link(chain, 5)));
    columns.set(static_cast<size_t>(layout_of(chain).couplings + 1));
    evaluator.poses(q, offsets, poses, some, columns);
    for (size_t k = 0; k < q.size(); ++k) {
      PoseJacobian expected;
      const Pose pose = evaluator.pose(q[k], offsets[k], expected);
      EXPECT_LT((poses[k].translation - pose.translation).norm(), 1e-13);
      EXPECT_LT((all[k / 4][k % 4] - expected).cwiseAbs().maxCoeff(), 1e-12);
      for (int c = 0; c < parameters; ++c)
        if (columns[static_cast<size_t>(c)])
          EXPECT_LT((some[k / 4][k % 4].col(c) - expected.col(c)).norm(), 1e-12) << c;
      KinematicChain moved = chain;
      // The parameters of base and tool turn about each other's axes: to first order only.
      for (int c = kFirstLinkParameter; c < parameters; ++c)
        if (!layout_of(chain).is_of_tool(c)) move_parameter(moved, c, offsets[k][c]);
      ParameterOffsets ends = offsets[k];
      for (int c = kFirstLinkParameter; c < parameters; ++c)
        if (!layout_of(chain).is_of_tool(c)) ends[c] = 0;
      EXPECT_LT((ChainEvaluator(moved).pose(q[k], ends).translation - pose.translation).norm(),
                1e-12);
    }
  }
}

TEST(Followers, InverseKinematicsReachesThem) {
  Uniform uniform(34);
  for (int i = 0; i < 20; ++i) {
    const KinematicChain chain = random_chain(uniform, true);
    const JointVector q = random_values(uniform, chain);
    JointVector start = q;
    for (double& value : start) value += uniform(-0.02, 0.02);
    const Pose wanted = ChainEvaluator(chain).pose(q);
    const InverseResult found = inverse_kinematics(chain, wanted, start);
    EXPECT_TRUE(found.reached);
    EXPECT_LT((ChainEvaluator(chain).pose(found.q).translation - wanted.translation).norm(), 1e-9);
  }
}

TEST(Followers, HaveNoColumnAndAParameterOfTheirOwn) {
  Uniform uniform(35);
  KinematicChain chain = random_chain(uniform, false);
  EXPECT_EQ(joint_count(chain), 5);
  EXPECT_EQ(joint_of_link(chain, 2), -1);
  EXPECT_EQ(link_of_joint(chain, 2), 3);
  const int first = layout_of(chain).couplings;
  EXPECT_EQ(parameter_name(chain, first + 1), "L5.follows.L2");
  EXPECT_EQ(find_parameter(chain, "L5.follows.L2"), first + 1);
  EXPECT_FALSE(find_parameter(chain, "L5.follows.L1"));
  const double before = chain.couplings[1].coefficient;
  move_parameter(chain, first + 1, 0.5);
  EXPECT_DOUBLE_EQ(chain.couplings[1].coefficient, before + 0.5);
  for (int k = 0; k < parameter_count(chain); ++k)
    EXPECT_EQ(find_parameter(chain, parameter_of(chain, k)), k);

  chain.couplings.push_back({5, 4, 1, 0});  // L3 follows L6, L5 follows L3
  EXPECT_THROW(ChainEvaluator{chain}, std::invalid_argument);
  chain.couplings.back() = {7, 4, 1, 0};  // the fixed link
  EXPECT_THROW(ChainEvaluator{chain}, std::invalid_argument);
}

// Only that of a joint without an encoder: the others state that of their encoder.
TEST(Followers, HaveATravel) {
  Uniform uniform(36);
  KinematicChain chain = random_chain(uniform, false);
  const JointVector q = random_values(uniform, chain);
  const double value = joint_values(chain, q)[4];
  chain.links[4].max = value + 0.01;
  EXPECT_FALSE(beyond_travel(chain, q));
  chain.links[4].max = value - 0.01;
  ASSERT_TRUE(beyond_travel(chain, q));
  EXPECT_EQ(beyond_travel(chain, q)->link, 4);
  EXPECT_DOUBLE_EQ(beyond_travel(chain, q)->value, value);
}

}  // namespace
}  // namespace armtrue::follower_test
