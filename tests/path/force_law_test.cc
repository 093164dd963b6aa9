#include "armtrue/path/mirror/force_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>
#include <stdexcept>

#include "armtrue/effects/sampling.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/path/joint_path.h"
#include "kinematics/six_axes.h"
#include "path/plant_pass.h"
#include "support/oracle.h"
#include "support/thinned.h"

namespace armtrue::force_law_test {
namespace {

using Random = std::mt19937_64;
constexpr Eigen::Index kSamples = 800;  // 26 s at 32 ms

double turns(Eigen::Index i, double number) {
  return std::sin(2 * M_PI * number * static_cast<double>(i) / kSamples);
}

// Air, then forces whose direction varies, then air.
Eigen::Matrix3Xd varied_force() {
  Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, kSamples);
  for (Eigen::Index i = 120; i < 700; ++i)
    force.col(i) << 10 + 8 * turns(i, 3), 40 + 10 * turns(i, 5), -15 + 6 * turns(i, 8);
  return force;
}

Eigen::Matrix3Xd slow_noise(double size, double rho, Random& random,
                            Eigen::Index samples = kSamples) {
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd noise(3, samples + 300);
  for (double& x : noise.reshaped()) x = normal(random);
  for (Eigen::Index i = 1; i < noise.cols(); ++i)
    noise.col(i) = rho * noise.col(i - 1) + std::sqrt(1 - rho * rho) * noise.col(i);
  return size * noise.rightCols(samples);
}

Eigen::Matrix3d stiffness_inverse() {
  Eigen::Matrix3d c;
  c << 15, 3, -2, 3, 22, 4, -2, 4, 12;
  return 1e-6 * c;  // um/N
}

bool holds(const Estimate& estimate, double truth) {
  return estimate.ci95[0] <= truth && truth <= estimate.ci95[1];
}

TEST(ForceLaw, ExactDataGiveTheWholeCompliance) {
  const Eigen::Matrix3Xd force = varied_force();
  const ForceLaw law = force_law({.deviation = stiffness_inverse() * force, .force = force});
  EXPECT_EQ(law.rank, 3);
  EXPECT_LT((law.compliance - stiffness_inverse()).norm(), 1e-15);
  EXPECT_TRUE(law.reversals.empty());
  EXPECT_GT(law.condition, 1);
}

TEST(ForceLaw, ExactDataGiveExactLines) {
  const Eigen::Matrix3Xd force = varied_force();
  const ForceLaw law = force_law({.deviation = 2.2e-5 * force, .force = force});
  for (const Estimate& offset : law.offset) EXPECT_NEAR(offset.value, 0, 1e-15);
  for (const ForceLine& line : law.axis) {
    ASSERT_TRUE(line.k);
    EXPECT_NEAR(line.k->value, 2.2e-5, 1e-18);
    EXPECT_NEAR(line.r2, 1, 1e-12);
  }
  EXPECT_NEAR(law.magnitude.k->value, 2.2e-5, 1e-18);
  // The share of the square about zero: y = (1, 2), x = (1, 1): k = 1.5, 1 - 0.5 / 5.
  EXPECT_DOUBLE_EQ(line_through_origin(Eigen::RowVector2d(1, 1), Eigen::RowVector2d(1, 2)).r2, 0.9);
}

TEST(ForceLaw, OneDirectionOfForceGivesOneColumnAndSaysSo) {
  const Eigen::Vector3d u = Eigen::Vector3d(0.15, 0.93, -0.34).normalized();
  Random random(4);
  Eigen::Matrix3Xd force = u * varied_force().row(1);
  const Eigen::Matrix3Xd deviation = stiffness_inverse() * force + slow_noise(2e-5, 0.8, random);
  force += slow_noise(0.6, 0, random);
  const ForceLaw law = force_law(
      {.deviation = deviation, .force = force, .force_noise = Eigen::Vector3d::Constant(0.6)});
  EXPECT_EQ(law.rank, 1);
  EXPECT_EQ(law.condition, 1);
  EXPECT_GT(law.directions[0].direction.dot(u), 0.9999);
  ASSERT_TRUE(law.directions[0].compliance);
  EXPECT_FALSE(law.directions[1].compliance);
  EXPECT_FALSE(law.directions[2].compliance);
  const Eigen::Vector3d truth = stiffness_inverse() * u;
  for (int a = 0; a < 3; ++a) EXPECT_NEAR((*law.directions[0].compliance)[a].value, truth[a], 1e-6);
  EXPECT_LT((law.compliance * u - truth).norm(), 1.5e-6);
  EXPECT_LT((law.compliance * u.unitOrthogonal()).norm(), 1e-6);
}

TEST(ForceLaw, AnAxisWithoutForceHasNoLine) {
  Eigen::Matrix3Xd force = varied_force();
  Random random(5);
  force.row(0) = slow_noise(0.6, 0, random).row(0);
  const ForceLaw law = force_law(
      {.deviation = 2e-5 * force, .force = force, .force_noise = Eigen::Vector3d::Constant(0.6)});
  EXPECT_FALSE(law.axis[0].k);
  EXPECT_TRUE(law.axis[1].k);
  EXPECT_EQ(law.rank, 2);
  const ForceLaw air = force_law(
      {.deviation = Eigen::Matrix3Xd::Ones(3, 50), .force = Eigen::Matrix3Xd::Zero(3, 50)});
  EXPECT_EQ(air.rank, 0);
  for (const ForceLine& line : air.axis) EXPECT_FALSE(line.k);
  EXPECT_FALSE(air.magnitude.k);
}

TEST(ForceLaw, AnAxisWhoseDeviationWasTakenOffHasNoLine) {
  const Eigen::Matrix3Xd force = varied_force();
  Eigen::Matrix3Xd deviation = 2e-5 * force;
  deviation.row(0).setZero();
  EXPECT_FALSE(force_law({.deviation = deviation, .force = force}).axis[0].k);
}

// Backlash of two joints: the deviation changes by `step` where their motion turns.
struct Backlash {
  Eigen::MatrixXd direction = Eigen::MatrixXd::Ones(3, kSamples);  // the third never turns
  Eigen::Matrix<double, 3, 2> step;
  Eigen::Vector3d offset{3e-5, -1e-4, 5e-5};

  Backlash() {
    direction.row(0).tail(kSamples - 400).setConstant(-1);
    direction.row(1).head(250).setConstant(-1);
    direction.row(1).tail(kSamples - 560).setConstant(-1);
    step << 1.2e-4, -4e-5, 3e-4, 1e-4, -8e-5, 1.5e-4;
  }
  Eigen::Matrix3Xd deviation() const {
    return (step * direction.topRows(2) / 2).colwise() + offset;
  }
};

TEST(ForceLaw, ReversalsDoNotBiasTheForcePart) {
  const Backlash backlash;
  const Eigen::Matrix3Xd force = varied_force();
  const ForceRecord record{.deviation = stiffness_inverse() * force + backlash.deviation(),
                           .force = force,
                           .direction = backlash.direction};
  const ForceLaw law = force_law(record);
  EXPECT_LT((law.compliance - stiffness_inverse()).norm(), 1e-15);
  ASSERT_EQ(law.reversals.size(), 2U);
  for (size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(law.reversals[s].axes, std::vector<Eigen::Index>{static_cast<Eigen::Index>(s)});
    for (size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(law.reversals[s].step[a].value,
                  backlash.step(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(s)), 1e-15);
  }
  ForceRecord blind = record;
  blind.direction.resize(0, 0);
  EXPECT_GT((force_law(blind).compliance - stiffness_inverse()).norm(), 2e-6);
}

TEST(ForceLaw, AxesThatReverseTogetherShareOneStep) {
  const Backlash backlash;
  ForceRecord record{
      .deviation = backlash.deviation(), .force = varied_force(), .direction = backlash.direction};
  record.direction.row(2) = -backlash.direction.row(1);
  const ForceLaw law = force_law(record);
  ASSERT_EQ(law.reversals.size(), 2U);
  EXPECT_EQ(law.reversals[1].axes, (std::vector<Eigen::Index>{1, 2}));
}

TEST(ForceLaw, AConstantForceCannotBeToldFromAnOffset) {
  const Backlash backlash;
  Eigen::Matrix3Xd force = Eigen::Vector3d(5, 40, -15).replicate(1, kSamples);
  const ForceLaw law = force_law({.deviation = 2e-5 * force + backlash.deviation(),
                                  .force = force,
                                  .direction = backlash.direction});
  EXPECT_EQ(law.rank, 0);
  EXPECT_FALSE(law.axis[1].k);
  EXPECT_NEAR(law.reversals[0].step[1].value, 3e-4, 1e-12);
}

// The whole: compliance, steps, noise in the measured force, residuals as slow as a low pass
// of 1.56 Hz leaves.
TEST(ForceLaw, IntervalsCoverTheTruth) {
  constexpr int kPasses = 600;
  const Backlash backlash;
  const Eigen::Matrix3Xd force = varied_force();
  const Eigen::Vector3d noise = Eigen::Vector3d::Constant(0.6);
  Random random(6);
  int compliance = 0, steps = 0, lines = 0;
  double bias = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::Matrix3Xd seen = force + slow_noise(0.6, 0, random);
    const Eigen::Matrix3Xd rest = slow_noise(5e-5, 0.8, random);
    const ForceLaw law =
        force_law({.deviation = stiffness_inverse() * force + backlash.deviation() + rest,
                   .force = seen,
                   .force_noise = noise,
                   .direction = backlash.direction});
    ASSERT_EQ(law.rank, 3);
    for (const ForceDirection& d : law.directions) {
      const Eigen::Vector3d truth = stiffness_inverse() * d.direction;
      for (int a = 0; a < 3; ++a) compliance += holds((*d.compliance)[a], truth[a]);
    }
    for (size_t s = 0; s < 2; ++s)
      for (size_t a = 0; a < 3; ++a)
        steps += holds(law.reversals[s].step[a],
                       backlash.step(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(s)));
    bias += law.compliance(2, 2) / stiffness_inverse()(2, 2) - 1;
    const ForceLaw alone =
        force_law({.deviation = 2.2e-5 * force + rest, .force = seen, .force_noise = noise});
    for (const ForceLine& line : alone.axis) lines += holds(*line.k, 2.2e-5);
  }
  const double shares[] = {compliance / (9.0 * kPasses), steps / (6.0 * kPasses),
                           lines / (3.0 * kPasses)};
  std::printf("covered: compliance %.3f, steps %.3f, k per axis %.3f\n", shares[0], shares[1],
              shares[2]);
  for (const double share : shares) {
    EXPECT_GE(share, 0.93);
    EXPECT_LE(share, 0.97);
  }
  EXPECT_NEAR(bias / kPasses, 0, 0.03);
}

// A pass of a program that a KR 360 cuts, and what its geometry can make of it: by the error of
// each length and angle of its links, kinematics of the product.
struct Cut {
  Eigen::Matrix3Xd place, force;
  std::vector<Eigen::Matrix3Xd> by_geometry;

  // In the second of two depths the force is twice as large. It follows the direction of the feed.
  Cut(plant::Shape shape, int depths) {
    const plant::Program program = plant::program(shape);
    Path path = path_of(program);
    const Robot arm = read_robot(ARMTRUE_CONFIG "/robots/kr360.yaml").robot;
    Context start;
    start.q = Eigen::Vector<double, 6>(0.1, -1.2, 1.5, 0.1, 0.6, 0.2);
    const Pose there = RobotModel(arm).pose(start);
    path.position.colwise() += there.translation - path.position.rowwise().mean();
    const Eigen::Matrix3Xd velocity = velocity_at(path, path.time);
    std::vector<Eigen::Index> moving;
    for (Eigen::Index i = 0; i < path.samples(); i += 2)
      if (velocity.col(i).norm() > 1e-3) moving.push_back(i);
    const auto n = std::ssize(moving);
    force = Eigen::Matrix3Xd::Zero(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double at = program.arc_length[moving[i]];
      if (at < program.entry || at > program.exit) continue;
      const Eigen::Vector3d feed = velocity.col(moving[i]).normalized();
      const bool deep = depths == 2 && 2 * at > program.entry + program.exit;
      const double varies = 1 + 0.15 * std::sin(80 * at) + 0.1 * std::sin(213 * at);
      force.col(i) =
          (deep ? 2 : 1) * varies *
          (-6 * feed + 38 * Eigen::Vector3d(-feed.y(), feed.x(), 0) - Eigen::Vector3d(0, 0, 13));
    }
    const JointMatrix q =
        joint_path(path, arm.chain, {.orientation = there.rotation, .start = start.q});
    const auto positions = [&](const Robot& robot) {
      Eigen::Matrix3Xd result(3, n);
      Context context;
      for (Eigen::Index i = 0; i < n; ++i) {
        context.q = q.col(moving[i]);
        result.col(i) = RobotModel(robot).pose(context).translation;
      }
      return result;
    };
    place = positions(arm);
    for (size_t link = 0; link < arm.chain.links.size(); ++link)
      for (double Link::*number : {&Link::alpha, &Link::d, &Link::theta, &Link::r}) {
        Robot wrong = arm;
        wrong.chain.links[link].*number += 1e-4;
        by_geometry.push_back(positions(wrong) - place);
      }
  }

  Eigen::Matrix3Xd geometry(double rms, Random& random) const {
    std::normal_distribution<double> normal;
    Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, place.cols());
    for (const Eigen::Matrix3Xd& of_one : by_geometry) sum += normal(random) * of_one;
    return rms / std::sqrt(sum.colwise().squaredNorm().mean()) * sum;
  }
};

// 0, 0.1 and 0.4 mm of what the geometry of the arm does, in one and in two depths of cut: it is no
// compliance. Without the places 0.94, 0.84 and 0.78 of the intervals held the truth.
TEST(ForceLaw, IntervalsCoverBesideTheGeometryOfTheArm) {
  const int part = thinned(4);
  Random random(9);
  for (const int depths : {1, 2})
    for (const double geometric : {0.0, 0.1e-3, 0.4e-3}) {
      int covered = 0, all = 0;
      for (const plant::Shape shape : {plant::Shape::line, plant::Shape::arc, plant::Shape::corner,
                                       plant::Shape::spiral, plant::Shape::pocket}) {
        const Cut cut(shape, depths);
        for (int pass = 0; pass < 60 / part; ++pass) {
          const Eigen::Index n = cut.force.cols();
          const ForceLaw law = force_law({.deviation = stiffness_inverse() * cut.force +
                                                       cut.geometry(geometric, random) +
                                                       slow_noise(2e-5, 0.8, random, n),
                                          .force = cut.force + slow_noise(0.6, 0, random, n),
                                          .force_noise = Eigen::Vector3d::Constant(0.6),
                                          .place = cut.place});
          for (const ForceDirection& d : law.directions) {
            if (!d.compliance) continue;
            const Eigen::Vector3d truth = stiffness_inverse() * d.direction;
            for (int a = 0; a < 3; ++a, ++all) covered += holds((*d.compliance)[a], truth[a]);
          }
        }
      }
      const double share = static_cast<double>(covered) / all;
      std::printf("%d depths, geometry of %.1f mm: covered %.3f\n", depths, 1e3 * geometric, share);
      EXPECT_NEAR(share, 0.95, 0.02 * std::sqrt(part)) << depths << " " << geometric;
    }
}

TEST(ForceLaw, RefusesSizesThatDisagreeAndTooFewSamples) {
  const Eigen::Matrix3Xd five = Eigen::Matrix3Xd::Ones(3, 5), nine = Eigen::Matrix3Xd::Ones(3, 9);
  EXPECT_THROW(force_law({.deviation = five, .force = nine}), std::invalid_argument);
  EXPECT_THROW(force_law({.deviation = five, .force = five}), std::invalid_argument);
  EXPECT_THROW(
      force_law({.deviation = nine, .force = nine, .direction = Eigen::MatrixXd::Ones(6, 5)}),
      std::invalid_argument);
  EXPECT_THROW(line_through_origin(five, nine), std::invalid_argument);
}

TEST(MotionDirections, StandstillKeepsTheLastMotion) {
  Eigen::MatrixXd q(2, 7);
  q << 0, 0, 1, 2, 2, 1, 0, 5, 5, 5, 5, 5, 5, 5;
  Eigen::MatrixXd expected(2, 7);
  expected << 1, 1, 1, 1, 1, -1, -1, 0, 0, 0, 0, 0, 0, 0;
  EXPECT_EQ(motion_directions(q), expected);
}

// J K^-1 J^T w by KDL's own chain and Jacobian.
TEST(DeviationFromForce, EqualsTheComplianceOfKdl) {
  const std::string file = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";
  Robot robot = read_robot(file).robot;
  const auto arm = armtrue_oracle::read_arm(file);
  const std::array<double, 6> compliance{4e-7, 3e-7, 5e-7, 2e-6, 3e-6, 6e-6};  // rad/(N m)
  for (size_t j = 0; j < 6; ++j)
    robot.effects.push_back({.name = "compliance",
                             .parameter = robot.chain.links[j].name + ".theta",
                             .driver = {.kind = DriverKind::force},
                             .shape = {},
                             .coefficients = {{.name = "c", .value = compliance[j]}}});
  // KDL turns about z after the fixed part before it, and moves along it by r after.
  KDL::Chain chain;
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), arm.base));
  for (size_t j = 0; j < 7; ++j) {
    const auto& link = arm.links[j];
    const KDL::Frame before(KDL::Rotation::RotY(link.beta) * KDL::Rotation::RotX(link.alpha));
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None),
                                  before * KDL::Frame(KDL::Vector(link.d, 0, 0)) *
                                      KDL::Frame(KDL::Rotation::RotZ(link.theta))));
    chain.addSegment(
        KDL::Segment(KDL::Joint(j < 6 ? KDL::Joint::RotZ : KDL::Joint::None, link.sign),
                     KDL::Frame(KDL::Vector(0, 0, link.r))));
  }
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), arm.tool));
  KDL::ChainJntToJacSolver solver(chain);

  Random random(8);
  std::normal_distribution<double> normal(0, 100);
  const std::vector<JointVector> sampled = sample_joint_space(robot.chain, 40);
  Eigen::Matrix<double, kJoints, Eigen::Dynamic> q(6, 40);
  Eigen::Matrix3Xd force(3, 40);
  for (Eigen::Index i = 0; i < 40; ++i) {
    q.col(i) = sampled[static_cast<size_t>(i)];
    for (int a = 0; a < 3; ++a) force(a, i) = normal(random);
  }
  const Eigen::Matrix3Xd deviation = deviation_from_force(RobotModel(robot), q, force);
  for (Eigen::Index i = 0; i < 40; ++i) {
    KDL::JntArray angles(6);
    angles.data = q.col(i);
    KDL::Jacobian jacobian(6);
    solver.JntToJac(angles, jacobian);
    const Eigen::MatrixXd linear = jacobian.data.topRows(3);
    const Eigen::Vector3d expected =
        linear * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(compliance.data()).asDiagonal() *
        (linear.transpose() * force.col(i));
    EXPECT_GT(expected.norm(), 1e-6);
    // To first order: the model turns the joints by the angle, KDL's product takes the tangent.
    EXPECT_NEAR((deviation.col(i) - expected).norm(), 0, 1e-3 * expected.norm()) << i;
  }
  EXPECT_TRUE(deviation_from_force(RobotModel(robot), q, Eigen::Matrix3Xd::Zero(3, 40)).isZero());
  EXPECT_THROW(deviation_from_force(RobotModel(robot), q, force.leftCols(3)),
               std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::force_law_test
