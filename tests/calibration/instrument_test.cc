// Effects of what reads the arm: the instrument, targets and wires.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"

namespace armtrue::instrument_test {
namespace {

Effect effect(const std::string& parameter, const Driver& driver, ShapeKind shape,
              const std::vector<double>& values) {
  Effect made{parameter, parameter, driver, {}, {}};
  made.shape.kind = shape;
  made.shape.at = 300;
  for (double value : values) made.coefficients.push_back({"c", value});
  return made;
}

Driver driver(DriverKind kind) { return {kind, -1, -1, ""}; }

Robot shipped() {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  robot.chain.base.translation = {0.4, -0.3, 0.2};
  robot.instrument = Eigen::Vector3d(3.5, -2.5, 1.1);
  return robot;
}

Robot with_errors_of_the_instrument() {
  Robot robot = shipped();
  robot.chain.targets = {{"a", {0.03, -0.02, 0.05}}, {"b", {-0.1, 0.07, 0.0}}};
  robot.effects = {
      effect("instrument.scale", driver(DriverKind::constant), ShapeKind::linear, {2e-5}),
      effect("instrument.range", driver(DriverKind::constant), ShapeKind::linear, {3e-4}),
      effect("instrument.range", driver(DriverKind::incidence), ShapeKind::harmonic, {1e-4, 2e-4}),
      effect("instrument.elevation", driver(DriverKind::range), ShapeKind::linear, {2e-5}),
      effect("instrument.azimuth", driver(DriverKind::azimuth), ShapeKind::harmonic, {1e-4, 5e-5}),
      effect("target b", driver(DriverKind::time), ShapeKind::step, {2e-4, -1e-4, 3e-4})};
  return robot;
}

// What one writes the other reads: the prediction of a campaign against the readings' model.
TEST(Instrument, ErrorsArePredictedAndRead) {
  const Robot robot = with_errors_of_the_instrument();
  SimulationOptions options;
  options.poses = 20;
  const Campaign campaign = simulate(shipped(), robot, options);
  EXPECT_LT(summarize(evaluate(robot, campaign).position).max, 1e-12);
  Robot blind = robot;
  blind.effects.clear();
  EXPECT_GT(summarize(evaluate(blind, campaign).position).mean, 2e-4);
}

void expect_differences(const Robot& robot, const Campaign& campaign) {
  const ObservationModel model(campaign, robot, {}, {1, 1});
  const int p = model.unknowns();
  const Eigen::VectorXd x = Eigen::VectorXd::Zero(p);
  Eigen::MatrixXd block(model.row_size(), p + 1);
  constexpr double kStep = 1e-5;
  for (int row = 0; row < campaign.rows(); ++row) {
    model.at(x).block(row, block);
    for (int k = 0; k < p; ++k) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p, k);
      const Eigen::VectorXd difference =
          (model.at(x - step).residual(row) - model.at(x + step).residual(row))
              .head(model.row_size()) /
          (2 * kStep);
      // Derivatives are taken at the arm without effects, which change it by some 1e-4.
      EXPECT_LT((block.col(k) - difference).norm(), 2e-3 * (1 + difference.norm()))
          << model.unknown_names()[static_cast<size_t>(k)];
    }
  }
}

TEST(Instrument, DerivativesAreDifferences) {
  const Robot robot = with_errors_of_the_instrument();
  SimulationOptions options;
  options.poses = 12;
  expect_differences(robot, simulate(shipped(), robot, options));
}

TEST(ArmScale, DerivativesAreDifferences) {
  Robot robot = shipped();
  robot.effects = {effect("arm.scale", driver(DriverKind::time), ShapeKind::linear, {1e-7}),
                   effect("instrument.scale", driver(DriverKind::time), ShapeKind::linear, {2e-8})};
  SimulationOptions options;
  options.poses = 12;
  expect_differences(robot, simulate(shipped(), robot, options));
}

TEST(Instrument, DerivativesOfWiresAreDifferences) {
  Robot robot = shipped();
  robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}}, {"2", {2.5, -1.5, 0.3}}};
  robot.effects = {
      effect("anchor 2.zero", driver(DriverKind::time), ShapeKind::step, {4e-4}),
      effect("anchor 1.x", driver(DriverKind::time), ShapeKind::step, {-3e-4}),
      effect("instrument.scale", driver(DriverKind::constant), ShapeKind::linear, {1e-5})};
  SimulationOptions options;
  options.poses = 12;
  options.repeats = 2;
  const Campaign campaign = simulate(shipped(), robot, options);
  EXPECT_LT(summarize(evaluate(robot, campaign).position).max, 1e-12);
  expect_differences(robot, campaign);
}

// R_A stands upright but for what the base tilts, and the fit tilts it otherwise than the file: the
// circle keeps its zero.
TEST(Instrument, CircleIsFittedHoweverTheBaseTilts) {
  constexpr double kTilt = 0.005;
  const auto tilted = [&](const Eigen::Vector3d& axis) {
    Robot robot = shipped();
    robot.chain.base.rotation *= Eigen::AngleAxisd(kTilt, axis).toRotationMatrix();
    robot.effects = {effect("instrument.azimuth", driver(DriverKind::azimuth), ShapeKind::harmonic,
                            {1e-3, 5e-4})};
    return robot;
  };
  const Robot truth = tilted(Eigen::Vector3d::UnitX());
  SimulationOptions options;
  options.poses = 40;
  options.noise_position = 0.05e-3;
  const Campaign campaign = simulate(truth, truth, options);
  const CalibrationResult fit = calibrate(tilted(Eigen::Vector3d::UnitY()), campaign);
  EXPECT_LT(summarize(evaluate(fit.robot, campaign).position).mean, 0.1e-3);
}

// The instrument of a session stands where that session's R_A puts it.
TEST(Instrument, GoesWithTheSession) {
  Robot robot = shipped();
  robot.effects = {
      effect("instrument.range", driver(DriverKind::constant), ShapeKind::linear, {5e-4})};
  const RobotModel model(robot);
  const Pose second{rotation_exp({0, 0, 0.8}), {0.7, 0.4, -0.1}};  // its R_A from the first
  Campaign campaign;
  campaign.source = "test";
  campaign.session_names = {"1", "2"};
  Robot there = robot;  // as the second session sees it
  there.chain.base = inverse(second) * robot.chain.base;
  const RobotModel of_second(there);
  for (const JointVector& q : random_configurations(robot, 10, {}, 3))
    for (int session : {0, 1}) {
      Context context;
      context.q = q;
      campaign.pose.push_back(campaign.rows());
      campaign.pose_ids.push_back(std::to_string(campaign.rows() + 1));
      campaign.line.push_back(1);
      campaign.q.push_back(q);
      campaign.session.push_back(session);
      campaign.position.push_back((session == 0 ? model : of_second).pose(context).translation);
    }
  robot.sessions["1"].base = robot.chain.base;
  robot.sessions["2"].base = there.chain.base;
  EXPECT_LT(summarize(evaluate(robot, campaign).position).max, 1e-12);
}

}  // namespace
}  // namespace armtrue::instrument_test
