#include "armtrue/path/simulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armtrue/io/path_io.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "support/oracle.h"

namespace armtrue::simulation_test {
namespace {

const std::string kSoft = ARMTRUE_CONFIG "/robots/kr360-roughing.yaml";

Path line() { return read_path(ARMTRUE_CONFIG "/paths/line300.csv").path; }
Robot soft() { return read_robot(kSoft).robot; }
Robot stiff() {
  Robot robot = soft();
  robot.effects.clear();
  return robot;
}

// Where a path is at a time, for the short steps of a program.
Eigen::Vector3d position_at(const Path& path, double t) {
  Eigen::Index i = 0;
  while (i + 2 < path.samples() && path.time[i + 1] <= t) ++i;
  const double u = (t - path.time[i]) / (path.time[i + 1] - path.time[i]);
  return (1 - u) * path.position.col(i) + u * path.position.col(i + 1);
}

TEST(JointPath, PutsTheToolOnThePath) {
  const Path path = line();
  const Robot robot = stiff();
  const auto q = joint_path(path, robot.chain);
  const ChainEvaluator chain(robot.chain);
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    const Pose pose = chain.pose(q.col(i));
    EXPECT_LT((pose.translation - path.position.col(i)).norm(), 1e-9);
    EXPECT_LT((pose.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-9);  // a = b = c = 0
    if (i > 0) EXPECT_LT((q.col(i) - q.col(i - 1)).norm(), 1e-3);
  }
}

TEST(JointPath, AnglesOfThePathBeforeItsCorrectionAreOnlyAHint) {
  Path path = line();
  const Robot robot = stiff();
  path.q = joint_path(path, robot.chain);
  path.position.row(1).array() += 1e-3;
  const auto q = joint_path(path, robot.chain);
  const Eigen::Vector3d end = ChainEvaluator(robot.chain).pose(q.rightCols<1>()).translation;
  EXPECT_LT((end - path.position.rightCols<1>()).norm(), 1e-9);
}

TEST(JointPath, TheBranchIsThatOfTheStart) {
  const Path path = line();
  const Robot robot = stiff();
  JointVector flipped = joint_path(path, robot.chain).col(0);
  flipped[3] += std::numbers::pi;
  flipped[4] = -flipped[4];
  flipped[5] -= std::numbers::pi;
  JointPathOptions options;
  options.start = flipped;
  const auto q = joint_path(path, robot.chain, options);
  EXPECT_LT((q.col(0) - flipped).norm(), 0.05);
}

Eigen::Index refused_sample(const Path& path, const KinematicChain& chain) {
  try {
    joint_path(path, chain);
  } catch (const UnreachableSample& error) {
    return error.sample;
  }
  return -1;
}

TEST(JointPath, RefusesWhatTheRobotCannotDo) {
  const Robot robot = stiff();
  Path path = line();
  path.position(1, 300) = -9;
  EXPECT_EQ(refused_sample(path, robot.chain), 300);

  path = line();
  KinematicChain narrow = robot.chain;
  const auto turning = joint_path(path, robot.chain).row(0).eval();
  (turning[0] < turning[400] ? narrow.links[0].max : narrow.links[0].min) = turning[400];
  EXPECT_NEAR(static_cast<double>(refused_sample(path, narrow)), 400, 1);

  path.q = joint_path(path, robot.chain);
  path.q.col(7)[0] += 0.1;
  EXPECT_EQ(refused_sample(path, robot.chain), 7);

  path = line();
  path.orientation.resize(Eigen::NoChange, 0);
  EXPECT_EQ(refused_sample(path, robot.chain), 0);
}

TEST(CuttingForce, IsThePapersAtItsDepths) {
  const Path path = line();
  Cut cut;
  for (const double depth : {0.003, 0.005, 0.008}) {
    cut.depth = depth;
    const Eigen::Matrix3Xd force = cutting_force(path, cut);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (Eigen::Index i = 0; i < path.samples(); ++i)
      if (path.position(0, i) > -0.09 && path.position(0, i) < 0.19) {
        sum += force.col(i);
        ++count;
      }
    EXPECT_NEAR(sum.norm() / count, 0.91 / 0.022 * depth / 0.008, 1.5 * depth / 0.008);
  }
}

TEST(CuttingForce, ActsWhereTheToolIsEngagedAndTurnsWithTheFeed) {
  Path path = line();
  Cut cut;
  cut.engaged = {0.05, 0.2};
  cut.variation = 0;
  const Eigen::Matrix3Xd along_x = cutting_force(path, cut);
  path.position.row(1).swap(path.position.row(0));
  const Eigen::Matrix3Xd along_y = cutting_force(path, cut);
  for (Eigen::Index i = 0; i < path.samples(); ++i) {
    const double s = path.position(1, i) + 0.1;
    const double share =
        s < 0.05 || s > 0.2 ? 0 : std::min({1.0, (s - 0.05) / 5e-3, (0.2 - s) / 5e-3});
    EXPECT_NEAR(along_x(1, i), 40 * share, 1e-6);
    EXPECT_NEAR(along_y(0, i), -40 * share, 1e-6);
    EXPECT_NEAR(along_y(1, i), along_x(0, i), 1e-6);
    EXPECT_EQ(along_y(2, i), along_x(2, i));
  }
  cut.engaged = {0.4, 0.5};
  EXPECT_THROW(cutting_force(path, cut), std::invalid_argument);
}

TEST(SimulatePass, WithoutEffectsTheInstrumentShowsTheProgramByItsOwnClock) {
  const Path path = line();
  PassOptions options;
  options.recorder.clock_offset = 1.25;
  options.recorder.clock_rate = 1e-4;
  const Path measured = simulate_pass(path, stiff(), stiff(), options);
  for (Eigen::Index i = 0; i < measured.samples(); ++i) {
    const double t = (measured.time[i] - 1.25) / 1.0001;
    EXPECT_LT((measured.position.col(i) - position_at(path, t)).norm(), 1e-7);
    if (i > 0) EXPECT_NEAR(measured.time[i] - measured.time[i - 1], 0.032, 1e-9);
  }
}

TEST(SimulatePass, TheForceMovesTheToolAsTheOracleSays) {
  const Path path = line();
  Robot truth = soft();
  std::erase_if(truth.effects, [](const Effect& e) { return e.driver.kind != DriverKind::force; });
  const Path measured = simulate_pass(path, stiff(), truth);
  const armtrue_oracle::OracleArm arm = armtrue_oracle::read_arm(kSoft);
  double largest = 0;
  for (Eigen::Index i = 0; i < measured.samples(); i += 25) {
    std::array<double, 6> q;
    for (size_t j = 0; j < 6; ++j) q[j] = measured.q(static_cast<Eigen::Index>(j), i);
    const KDL::Vector rest = armtrue_oracle::forward(arm, q).p;
    std::array<double, 6> bent = q;
    for (size_t j = 0; j < 6; ++j) {
      std::array<double, 6> turned = q;
      turned[j] += 1e-6;
      const KDL::Vector lever = (armtrue_oracle::forward(arm, turned).p - rest) / 1e-6;
      const double torque = lever.x() * measured.force(0, i) + lever.y() * measured.force(1, i) +
                            lever.z() * measured.force(2, i);
      bent[j] += truth.effects[j].coefficients[0].value * torque;
    }
    const KDL::Vector moved = armtrue_oracle::forward(arm, bent).p;
    const Eigen::Vector3d expected(moved.x(), moved.y(), moved.z());
    EXPECT_LT((measured.position.col(i) - expected).norm(), 1e-8);
    largest = std::max(largest, (expected - Eigen::Vector3d(rest.x(), rest.y(), rest.z())).norm());
  }
  EXPECT_GT(largest, 0.8e-3);  // the paper's line: 0.91 mm on average
}

TEST(SimulatePass, AReversalOfAJointIsAStep) {
  const Path path = line();
  Robot truth = soft();
  std::erase_if(truth.effects, [](const Effect& e) { return e.driver.kind == DriverKind::force; });
  const Path measured = simulate_pass(path, stiff(), truth);
  const ChainEvaluator chain(truth.chain);
  int steps = 0;
  double before = 0;
  for (Eigen::Index i = 0; i < measured.samples(); ++i) {
    const double z = measured.position(2, i) - chain.pose(measured.q.col(i)).translation.z();
    if (std::abs(z - before) > 20e-6) ++steps;
    before = z;
  }
  EXPECT_EQ(steps, 3);  // both joints start; joint 3 turns back, then joint 2
}

TEST(SimulatePass, TheLagOfASteadyFeedIsItsTimeConstant) {
  const Path path = line();
  PassOptions options;
  options.lag = 0.02;
  const Path measured = simulate_pass(path, stiff(), stiff(), options);
  const Eigen::Index middle = measured.samples() / 2;
  const double behind = position_at(path, measured.time[middle]).x() - measured.position(0, middle);
  EXPECT_NEAR(behind, 0.02 * 0.027, 1e-6);
  EXPECT_NEAR(measured.position(0, measured.samples() - 1), 0.2, 1e-9);
}

TEST(SimulatePass, NoiseAndLossesAreAsLargeAsAsked) {
  const Path path = line();
  PassOptions options;
  const Path clean = simulate_pass(path, soft(), soft(), options);
  options.recorder.noise = 0.1e-3;
  options.recorder.force_noise = 2;
  const Path noisy = simulate_pass(path, soft(), soft(), options);
  const double n = static_cast<double>(3 * clean.samples());
  EXPECT_NEAR((noisy.position - clean.position).norm() / std::sqrt(n), 0.1e-3, 5e-6);
  EXPECT_NEAR((noisy.force - clean.force).norm() / std::sqrt(n), 2, 0.1);
  options.recorder.lost = 0.1;
  const Path lossy = simulate_pass(path, soft(), soft(), options);
  EXPECT_NEAR(static_cast<double>(lossy.samples()) / static_cast<double>(clean.samples()), 0.9,
              0.04);
}

}  // namespace
}  // namespace armtrue::simulation_test
