#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/compensation/error_map.h"
#include "compensation/second_arm.h"

namespace armtrue::coverage_test {
namespace {

using armtrue_oracle::OracleArm;
using armtrue_oracle::Uniform;

Robot known_arm(Uniform& uniform, double size) {
  Robot robot = random_arm(uniform);
  robot.effects = {effect_on("base.x", "time", "linear", {1e-6}),
                   effect_on("A3.theta", "gravity-torque 3", "linear", {2e-7})};
  Uncertainty known;
  known.parameters = {"base.z", "A2.theta", "A3.d", "A4.alpha", "tool.y"};
  const std::vector<double> scale{1e-2, 1e-4, 2e-4, 1e-4, 1e-2, 1e-6, 3e-8};
  known.root = Eigen::MatrixXd::Zero(7, 7);
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column <= row; ++column)
      known.root(row, column) = size * scale[static_cast<size_t>(row)] * uniform(-1, 1);
  known.reading = {1e-4, 1e-4};
  known.largest_variance = 1;
  known.poses = 50;
  robot.uncertainty = known;
  return robot;
}

// The links and the effect on a link count; base, tool and the drift of the instrument do not.
TEST(Coverage, IsTheDeviationOfTheArmAlone) {
  Uniform uniform(21);
  const Robot nominal = read_robot(kNominalArm).robot;
  const Robot robot = known_arm(uniform, 1);
  CompensationOptions options;
  options.tool = {rotation_from_abc(0.3, -0.8, 1.1), {0.05, -0.02, 0.21}};
  const KDL::Frame tcp = kdl_frame(options.tool);
  const OracleArm arm = second(robot);
  for (int k = 0; k < 20; ++k) {
    const JointVector q = random_target(nominal.chain, uniform);
    const Program program = joint_program({q});
    const CorrectedTarget target = compensate(robot, nominal, program, options).front();
    const auto sag = [](double c) -> armtrue_oracle::HiddenEffect {
      return [c](const armtrue_oracle::Moment& m, OracleArm& a) {
        a.links[2].theta += c * m.torque[2];
      };
    };
    double variance = 0;
    const KDL::Frame here = second_pose(arm, {sag(2e-7)}, tcp, q, {});
    for (int column = 0; column < 7; ++column) {
      const auto& root = robot.uncertainty->root;
      OracleArm moved = arm;
      moved.links[1].theta += root(1, column);
      moved.links[2].d += root(2, column);
      moved.links[3].alpha += root(3, column);
      const KDL::Frame there = second_pose(moved, {sag(2e-7 + root(6, column))}, tcp, q, {});
      variance += std::pow(metres_between(here, there), 2);
    }
    ASSERT_TRUE(target.deviation);
    EXPECT_NEAR(*target.deviation, std::sqrt(variance), 1e-3 * std::sqrt(variance));
    // What the model lacks comes on top, along each axis.
    Robot lacking = robot;
    lacking.uncertainty->rest = 1e-4;
    const CorrectedTarget less_sure = compensate(lacking, nominal, program, options).front();
    EXPECT_NEAR(*less_sure.deviation, std::sqrt(variance + 3e-8), 1e-3 * std::sqrt(variance));
    EXPECT_LT(*target.leverage, 1);
  }
}

// The foot rises with the angle of joint 2, or the instrument does: it is not applied, and if it is
// the arm's, the tool errs by it.
TEST(Coverage, ContainsWhatMayBeTheArmsAndIsNotApplied) {
  Uniform uniform(24);
  const Robot nominal = read_robot(kNominalArm).robot;
  Robot robot = known_arm(uniform, 1);
  CompensationOptions options;
  const auto deviation_at = [&](const JointVector& q) {
    return *compensate(robot, nominal, joint_program({q}), options).front().deviation;
  };
  for (int k = 0; k < 5; ++k) {
    const JointVector q = random_target(nominal.chain, uniform);
    robot.effects.resize(2);
    const double without = deviation_at(q);
    Effect rise = effect_on("base.z", "joint-angle 2", "linear", {3e-3});
    rise.may_be_instrument = true;
    rise.mean = 1e-3;
    robot.effects.push_back(rise);
    EXPECT_NEAR(deviation_at(q), std::hypot(without, 3e-3 * q[1] - 1e-3), 0.02 * without);
    const ErrorMap map = map_errors(robot, nominal, joint_program({q}), options);
    EXPECT_NEAR(*map.points.front().deviation, deviation_at(q), 1e-12);
    EXPECT_NEAR(*map.points.front().after, std::hypot(deviation_at(q), std::sqrt(3.0) * 1e-4),
                1e-12);
    // The drift of the instrument is none of the arm, whatever it may be.
    robot.effects.back() = effect_on("base.x", "time", "linear", {1e-3});
    robot.effects.back().may_be_instrument = true;
    EXPECT_NEAR(deviation_at(q), without, 1e-9);
  }
}

TEST(Coverage, LinksMayHoldTheStation) {
  Uniform uniform(23);
  Robot robot = known_arm(uniform, 1);
  Uncertainty& known = *robot.uncertainty;
  EXPECT_TRUE(parameters_of_station(robot).empty());
  known.parameters = {"A1.d", "A2.theta", "A6.r", "A6.d", "spindle.d"};
  EXPECT_EQ(parameters_of_station(robot), (std::vector<std::string>{"A1.d", "A6.r", "spindle.d"}));
  for (const char* name : {"base.x", "base.y", "base.z", "base.rx", "base.ry", "base.rz"})
    known.parameters.emplace_back(name);
  EXPECT_EQ(parameters_of_station(robot), (std::vector<std::string>{"A6.r", "spindle.d"}));
  robot.uncertainty.reset();
  robot.std = {{"A1.theta", 1e-4}, {"A3.d", 1e-4}};
  EXPECT_EQ(parameters_of_station(robot), (std::vector<std::string>{"A1.theta"}));
}

TEST(Coverage, NamesWhatTheReadingsDoNotCover) {
  Uniform uniform(22);
  const Robot nominal = read_robot(kNominalArm).robot;
  Robot robot = known_arm(uniform, 100);
  robot.uncertainty->largest_variance = 100;
  const Program program = joint_program({random_target(nominal.chain, uniform)});
  CompensationOptions options;
  const CorrectedTarget vague = compensate(robot, nominal, program, options).front();
  EXPECT_TRUE(vague.has(CommandNote::below_std));
  EXPECT_FALSE(vague.has(CommandNote::outside_readings));
  EXPECT_TRUE(vague.is_corrected);

  robot.uncertainty->largest_variance = 1e-9;
  EXPECT_TRUE(
      compensate(robot, nominal, program, options).front().has(CommandNote::outside_readings));
  options.correct_uncovered = false;
  const CorrectedTarget left = compensate(robot, nominal, program, options).front();
  EXPECT_FALSE(left.is_corrected);
  EXPECT_EQ(left.q, program.visits.q.front());
  EXPECT_EQ(left.after.position, left.before.position);

  robot.uncertainty.reset();
  const CorrectedTarget unknown = compensate(robot, nominal, program, options).front();
  EXPECT_FALSE(unknown.deviation || unknown.leverage);
  EXPECT_TRUE(unknown.is_corrected);
}

}  // namespace
}  // namespace armtrue::coverage_test
