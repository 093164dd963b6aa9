#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <numbers>
#include <vector>

#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "kinematics/jet_chain.h"
#include "kinematics/kdl_arm.h"
#include "kinematics/places.h"
#include "kinematics/six_axes.h"
#include "support/random_chain.h"

namespace armtrue::chain_test {
namespace {

using armtrue_oracle::Uniform;

KinematicChain random_chain(Uniform& uniform, bool with_beta) {
  KinematicChain chain;
  chain.links = six_axis_links();
  for (Link& link : chain.links) {
    link.alpha = uniform(-3, 3);
    link.d = uniform(-1.5, 1.5);
    link.theta = uniform(-3, 3);
    link.r = uniform(-1.5, 1.5);
    link.beta = with_beta ? uniform(-0.3, 0.3) : 0;
    link.sign = uniform(0, 1) < 0.5 ? -1 : 1;
    link.name = "L" + std::to_string(&link - chain.links.data() + 1);
  }
  for (Pose* pose : {&chain.base, &chain.tool}) {
    pose->rotation = rotation_exp({uniform(-2, 2), uniform(-1, 1), uniform(-1, 1)});
    pose->translation = {uniform(-2, 2), uniform(-2, 2), uniform(-2, 2)};
  }
  return chain;
}

JointVector random_angles(Uniform& uniform) {
  JointVector q(6);
  for (int j = 0; j < kJoints; ++j) q[j] = uniform(-3, 3);
  return q;
}

Pose kdl_pose(const KinematicChain& chain, const JointVector& q) {
  const KDL::Chain arm = kdl_arm(chain);
  KDL::JntArray angles(kJoints);
  angles.data = q;
  KDL::ChainFkSolverPos_recursive solver(arm);
  KDL::Frame frame;
  solver.JntToCart(angles, frame);
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    pose.translation[i] = frame.p[i];
    for (int k = 0; k < 3; ++k) pose.rotation(i, k) = frame.M(i, k);
  }
  return pose;
}

TEST(Chain, EqualsKdlOnRandomChains) {
  Uniform uniform(11);
  for (int i = 0; i < 200; ++i) {
    const KinematicChain chain = random_chain(uniform, false);
    const JointVector q = random_angles(uniform);
    const Pose own = ChainEvaluator(chain).pose(q), kdl = kdl_pose(chain, q);
    EXPECT_LT((own.translation - kdl.translation).norm(), 1e-12);
    EXPECT_LT((own.rotation - kdl.rotation).norm(), 1e-12);
  }
}

TEST(Chain, FlangeOfTheKr360StandsWhereThePublishedCheckSays) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  JointVector q = JointVector::Zero(6);
  q[1] = -std::numbers::pi / 2;
  q[2] = std::numbers::pi / 4;
  const Eigen::Vector3d flange = ChainEvaluator(robot.chain).pose(q).translation * 1000;
  EXPECT_NEAR(flange.x(), 1468.736, 1e-3);
  EXPECT_NEAR(flange.y(), 0, 1e-3);
  EXPECT_NEAR(flange.z(), 3235.955, 1e-3);
}

TEST(Chain, BothEncoderZerosOfTheKr360AreTheSameArm) {
  const Robot kuka = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
  const Robot eq1 = read_robot(ARMTRUE_CONFIG "/robots/kr360-eq1-zero.yaml").robot;
  Uniform uniform(12);
  for (int i = 0; i < 20; ++i) {
    const JointVector q = random_angles(uniform);
    JointVector shifted = q;
    for (int j = 0; j < kJoints; ++j)
      shifted[j] += kuka.chain.links[j].theta - eq1.chain.links[j].theta;
    EXPECT_LT((ChainEvaluator(kuka.chain).pose(q).translation -
               ChainEvaluator(eq1.chain).pose(shifted).translation)
                  .norm(),
              1e-12);
  }
}

// d(pose)/d(parameters) of the independent chain; rotation rows are the axial part of dR R^T.
PoseJacobian autodiff_jacobian(const KinematicChain& chain, const JointVector& q,
                               const Eigen::Vector3d& point) {
  const auto frame =
      jet_frame<kGeometricParameters>(chain, jet_parameters<kGeometricParameters>(chain), q);
  PoseJacobian jacobian(6, kGeometricParameters);
  for (int k = 0; k < kGeometricParameters; ++k) {
    Eigen::Matrix3d r, dr;
    for (int i = 0; i < 3; ++i) {
      jacobian(i, k) = frame(i, 3).v[k];
      for (int c = 0; c < 3; ++c) {
        r(i, c) = frame(i, c).a;
        dr(i, c) = frame(i, c).v[k];
        jacobian(i, k) += frame(i, c).v[k] * point[c];
      }
    }
    const Eigen::Matrix3d spin = dr * r.transpose();
    jacobian.col(k).tail<3>() << spin(2, 1), spin(0, 2), spin(1, 0);
  }
  return jacobian;
}

void expect_same_columns(const KinematicChain& chain, const PoseJacobian& own,
                         const PoseJacobian& expected) {
  for (int k = 0; k < kGeometricParameters; ++k)
    EXPECT_LT((own.col(k) - expected.col(k)).norm(), 1e-9 * (expected.col(k).norm() + 1e-3))
        << "column " << parameter_name(chain, k);
}

TEST(Jacobian, EveryColumnEqualsAutodiff) {
  Uniform uniform(13);
  for (int i = 0; i < 50; ++i) {
    const KinematicChain chain = random_chain(uniform, true);
    const JointVector q = random_angles(uniform);
    PoseJacobian own;
    const Pose pose = ChainEvaluator(chain).pose(q, own);
    expect_same_columns(chain, own, autodiff_jacobian(chain, q, Eigen::Vector3d::Zero()));
    // The same for a reflector off the tool's origin.
    const Eigen::Vector3d target(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    move_to_point(own, pose.rotation * target);
    expect_same_columns(chain, own, autodiff_jacobian(chain, q, target));
  }
}

TEST(Jacobian, OffsetsEqualAChainWithMovedParameters) {
  Uniform uniform(14);
  for (int i = 0; i < 50; ++i) {
    const KinematicChain chain = random_chain(uniform, true);
    const JointVector q = random_angles(uniform);
    ParameterOffsets offsets = ParameterOffsets::Zero(kGeometricParameters);
    KinematicChain moved = chain;
    for (int k = 0; k < kGeometricParameters; ++k) {
      // One turn each of base and tool: rotation vectors do not add component by component.
      const bool turn =
          k == 4 || k == 5 || k == kFirstToolParameter + 3 || k == kFirstToolParameter + 4;
      if (turn) continue;
      offsets[k] = uniform(-0.01, 0.01);
      move_parameter(moved, k, offsets[k]);
    }
    PoseJacobian own, expected;
    const Pose a = ChainEvaluator(chain).pose(q, offsets, own);
    const Pose b = ChainEvaluator(moved).pose(q, expected);
    EXPECT_LT((a.translation - b.translation).norm(), 1e-13);
    EXPECT_LT((a.rotation - b.rotation).norm(), 1e-13);
    expect_same_columns(chain, own, expected);
  }
}

// A chain whose base, tool and links stand at a place: its rotation vectors give base and tool, and
// one component after the other the angles of the links.
class ChainLaws : public testing::TestWithParam<Place> {
 protected:
  struct Sample {
    KinematicChain chain;
    JointVector q;
    Eigen::Vector3d base_turn, tool_turn;  ///< at the place too
  };
  std::vector<Sample> samples() {
    constexpr size_t kSamples = 30;
    const std::vector<Eigen::Vector3d> w = rotation_vectors(GetParam(), 2 * kSamples);
    Uniform uniform(16);
    std::vector<Sample> result;
    for (size_t i = 0; i < kSamples; ++i) {
      size_t next = i;
      const auto angle = [&] {
        ++next;
        return w[next % w.size()][static_cast<int>(next % 3)];
      };
      Sample sample{random_chain(uniform, false), JointVector::Zero(6), w[2 * i], w[2 * i + 1]};
      sample.chain.base.rotation = rotation_exp(w[i]);
      sample.chain.tool.rotation = rotation_exp(w[kSamples + i]);
      for (int j = 0; j < kLinks; ++j) {
        Link& link = sample.chain.links[j];
        link.alpha = angle();
        link.beta = angle();
        link.theta = angle();
        if (j < kJoints) sample.q[j] = angle();
      }
      result.push_back(sample);
    }
    return result;
  }
};

INSTANTIATE_TEST_SUITE_P(, ChainLaws, testing::ValuesIn(kPlaces), place_name);

// The difference of two poses as the rows of a Jacobian have it: exp(dr) `from` = `to`.
Eigen::Matrix<double, 6, 1> difference(const Pose& from, const Pose& to) {
  Eigen::Matrix<double, 6, 1> result;
  result << to.translation - from.translation,
      rotation_log(to.rotation * from.rotation.transpose());
  return result;
}

TEST_P(ChainLaws, EveryColumnIsWhatAPerturbationDoes) {
  // Central differences of an arm of at most 20 m truncate 20 step^2 / 6 = 3e-10 and round
  // 20 epsilon / step = 4e-10.
  constexpr double kStep = 1e-5, kBound = 1e-9;
  for (const auto& [chain, q, base_turn, tool_turn] : samples()) {
    PoseJacobian own;
    const Pose pose = ChainEvaluator(chain).pose(q, own);
    const Eigen::Vector3d target(0.3, -0.7, 0.5);
    PoseJacobian at_target = own;
    move_to_point(at_target, pose.rotation * target);
    for (int k = 0; k < kGeometricParameters; ++k) {
      KinematicChain plus = chain, minus = chain;
      move_parameter(plus, k, kStep);
      move_parameter(minus, k, -kStep);
      const Pose to = ChainEvaluator(plus).pose(q), from = ChainEvaluator(minus).pose(q);
      EXPECT_LE((difference(from, to) / (2 * kStep) - own.col(k)).norm(), kBound)
          << "column " << parameter_name(chain, k);
      const Eigen::Vector3d moved = (to * target - from * target) / (2 * kStep);
      EXPECT_LE((moved - at_target.col(k).head<3>()).norm(), kBound)
          << "target, column " << parameter_name(chain, k);
    }
  }
}

TEST_P(ChainLaws, OffsetsTurnBaseAndToolOnTheLeft) {
  for (const auto& [chain, q, base_turn, tool_turn] : samples()) {
    ParameterOffsets offsets = ParameterOffsets::Zero(kGeometricParameters);
    offsets.segment<3>(kFirstBaseParameter + 3) = base_turn;
    offsets.segment<3>(kFirstToolParameter + 3) = tool_turn;
    KinematicChain moved = chain;
    moved.base.rotation = rotation_exp(base_turn) * chain.base.rotation;
    moved.tool.rotation = rotation_exp(tool_turn) * chain.tool.rotation;
    PoseJacobian own, expected;
    const Pose a = ChainEvaluator(chain).pose(q, offsets, own);
    const Pose b = ChainEvaluator(moved).pose(q, expected);
    EXPECT_EQ(a.translation, b.translation);
    EXPECT_EQ(a.rotation, b.rotation);
    EXPECT_EQ(own, expected);
  }
}

TEST_P(ChainLaws, LinkFramesEndInThePose) {
  for (const auto& [chain, q, base_turn, tool_turn] : samples()) {
    const ChainEvaluator evaluator(chain);
    const Pose whole = chain.base * evaluator.link_frames(q).back() * chain.tool;
    // Some twenty rotations in a row, of at most 30 m.
    EXPECT_LE(difference(whole, evaluator.pose(q)).norm(), 1e-14);
  }
}

TEST(Parameters, NamesFindTheirIndexAndMoveWhatTheySay) {
  Uniform uniform(15);
  KinematicChain chain = random_chain(uniform, true);
  chain.targets.push_back({"7", {0, 0, 0}});
  for (int k = 0; k < parameter_count(chain); ++k)
    EXPECT_EQ(find_parameter(chain, parameter_name(chain, k)), k) << parameter_name(chain, k);
  EXPECT_FALSE(find_parameter(chain, "L8.alpha"));
  EXPECT_EQ(find_parameter(chain, "target 7.y"), kTargetParameters + 1);
}

// A name of a link, with dots, blanks or the words of other owners, is a name.
TEST(Parameters, ANameDoesNotDecideWhoseAParameterIs) {
  Uniform uniform(15);
  KinematicChain chain = random_chain(uniform, true);
  const std::vector<std::string> names{"base_wrist", "A1.theta",    "target 1",   "anchor.zero",
                                       "tool.rx",    "my axis (5)", "instrument."};
  for (size_t j = 0; j < chain.links.size(); ++j) chain.links[j].name = names[j % names.size()];
  chain.targets = {{"1", {}}, {"nose.left", {}}};
  chain.anchors = {{"wall 2", {}}};
  EXPECT_EQ(ambiguous_parameter(chain), std::nullopt);
  const ParameterLayout layout = layout_of(chain);
  for (int k = 0; k < parameter_count(chain); ++k) {
    const Parameter parameter(parameter_name(chain, k));
    EXPECT_EQ(parameter, parameter_of(chain, k));
    EXPECT_EQ(parameter.owner == Owner::link, layout.is_of_links(k)) << parameter;
    EXPECT_EQ(parameter.owner == Owner::instrument, layout.is_of_instrument(k)) << parameter;
  }
  EXPECT_EQ(Parameter("base").component, Parameter::kWhole);
  EXPECT_EQ(Parameter("target nose.left"),
            Parameter(Owner::target, "nose.left", Parameter::kWhole));
  EXPECT_EQ(Parameter("instrument.point").owner, Owner::instrument);
  EXPECT_EQ(Parameter("arm.scale").owner, Owner::arm);
  EXPECT_EQ(Parameter("arm").owner, Owner::several);
  EXPECT_EQ(Parameter("compliance of the arm").owner, Owner::several);
}

TEST(Parameters, ANameThatMeansTwoThingsIsFound) {
  KinematicChain chain;
  chain.links = six_axis_links();
  for (size_t j = 0; j < chain.links.size(); ++j) chain.links[j].name = "A" + std::to_string(j);
  EXPECT_EQ(ambiguous_parameter(chain), std::nullopt);
  chain.targets = {{"1", {}}, {"1.x", {}}};
  EXPECT_EQ(to_string(*ambiguous_parameter(chain)), "target 1.x");
  chain.targets = {{"nose.theta", {}}};
  EXPECT_EQ(to_string(*ambiguous_parameter(chain)), "target nose.theta");
}

}  // namespace
}  // namespace armtrue::chain_test
