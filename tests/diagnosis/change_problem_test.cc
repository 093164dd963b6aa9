// The fit of what may have moved adds the rows up in blocks; here by dense matrices of all rows.
#include "diagnosis/change_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue::change_problem_test {
namespace {

Robot shipped(const std::string& name) {
  return read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
}

Campaign measured(const Robot& truth, int poses, int repeats, unsigned seed) {
  SimulationOptions options;
  options.poses = poses;
  options.repeats = repeats;
  options.seed = seed;
  options.noise_position = 0.095e-3;
  options.noise_orientation = 0.15e-3;
  return simulate(shipped("kr360-spindle"), truth, options);
}

struct Dense {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance, by_pose;
};

// `parameters`: errors of known deviation, then the moves, of which nothing is known.
Dense dense_fit(const Robot& previous, const Campaign& campaign, const ReadingSigma& sigma,
                const std::vector<int>& parameters, const Eigen::VectorXd& weight, double share) {
  // A parameter that moves has two unknowns, and its change is their sum.
  std::vector<int> distinct = parameters;
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  const ObservationModel model(campaign, previous, distinct, sigma, 0);
  const Eigen::Index count = std::ssize(parameters), columns = std::ssize(distinct);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(columns, count);
  for (Eigen::Index k = 0; k < count; ++k)
    sum(std::ranges::find(distinct, parameters[static_cast<size_t>(k)]) - distinct.begin(), k) = 1;
  const Eigen::Index equations = model.rows() * model.row_size();
  Dense result{Eigen::VectorXd::Zero(count), {}, {}};
  Eigen::MatrixXd rows(equations + count, count);
  Eigen::VectorXd residual(equations + count);
  for (int step = 0; step < 10; ++step) {
    const ObservationModel::At at = model.at(sum * result.x);
    Eigen::MatrixXd block(model.row_size(), columns + 1);
    for (int row = 0; row < model.rows(); ++row) {
      at.block(row, block);
      block *= std::sqrt(share);
      rows.middleRows(row * model.row_size(), model.row_size()) = block.leftCols(columns) * sum;
      residual.segment(row * model.row_size(), model.row_size()) = block.col(columns);
    }
    rows.bottomRows(count) = weight.asDiagonal();
    residual.tail(count) = -weight.cwiseProduct(result.x);
    const Eigen::VectorXd unit = rows.colwise().norm().cwiseInverse();
    if (step < 9)
      result.x += unit.asDiagonal() *
                  Eigen::VectorXd((rows * unit.asDiagonal()).colPivHouseholderQr().solve(residual));
  }
  const Eigen::VectorXd unit = rows.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = rows * unit.asDiagonal();
  result.covariance =
      unit.asDiagonal() *
      Eigen::MatrixXd(
          (scaled.transpose() * scaled).ldlt().solve(Eigen::MatrixXd::Identity(count, count))) *
      unit.asDiagonal();
  const int poses = static_cast<int>(campaign.pose_ids.size());
  Eigen::MatrixXd changes(count, poses);
  for (int pose = 0; pose < poses; ++pose) {
    std::vector<Eigen::Index> own;
    for (int row = 0; row < campaign.rows(); ++row)
      for (int i = 0; campaign.pose[static_cast<size_t>(row)] == pose && i < model.row_size(); ++i)
        own.push_back(row * model.row_size() + i);
    const Eigen::MatrixXd a = rows(own, Eigen::all);
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(a.rows(), a.rows()) - a * result.covariance * a.transpose();
    changes.col(pose) =
        result.covariance * a.transpose() * left.ldlt().solve(Eigen::VectorXd(residual(own)));
  }
  const Eigen::VectorXd mean = changes.rowwise().mean();
  const Eigen::MatrixXd off = changes.colwise() - mean;
  result.by_pose = (poses - 1.0) / poses * off * off.transpose() +
                   result.covariance * weight.cwiseAbs2().asDiagonal() * result.covariance;
  return result;
}

// `repeats`: so many readings of a pose that they are folded on the way.
void expect_dense(int poses, int repeats) {
  Robot truth = shipped("kr360-table4");
  const CalibrationResult previous = calibrate(shipped("kr360-spindle"), measured(truth, 60, 3, 1));
  move_parameter(truth.chain, *find_parameter(truth.chain, "A2.theta"), 5e-4);
  const Campaign campaign = measured(truth, poses, repeats, 2);
  const ReadingSigma sigma{0.1e-3, 0.16e-3};
  const ChangeProblem problem(previous.robot, campaign, sigma);
  std::optional<ChangeProblem::Fit> fit;
  int moved = -1;
  for (int k = 0; k < problem.hypotheses() && moved < 0; ++k) {
    fit = problem.fit({k}, {});
    problem.complete({k}, *fit);
    if (problem.described({k}, 0, *fit).what == "A2.theta") moved = k;
  }
  ASSERT_GE(moved, 0);

  std::vector<int> parameters;
  std::vector<double> weights;
  for (int k = 0; k < parameter_count(previous.robot.chain); ++k) {
    const auto known = previous.robot.std.find(parameter_name(previous.robot.chain, k));
    if (known == previous.robot.std.end() || !(known->second > 0)) continue;
    parameters.push_back(k);
    weights.push_back(1 / known->second);
  }
  parameters.push_back(*find_parameter(truth.chain, "A2.theta"));
  weights.push_back(0);
  ASSERT_EQ(fit->x.size(), std::ssize(parameters));
  const Dense dense =
      dense_fit(previous.robot, campaign, sigma, parameters,
                Eigen::VectorXd::Map(weights.data(), std::ssize(weights)), 1.0 / repeats);
  EXPECT_NEAR(fit->x.tail(1)[0], 5e-4, 1e-4);
  for (Eigen::Index k = 0; k < fit->x.size(); ++k) {
    const double deviation = std::sqrt(dense.covariance(k, k));
    EXPECT_NEAR(fit->x[k], dense.x[k], 1e-4 * deviation);
    EXPECT_NEAR(fit->covariance(k, k), dense.covariance(k, k), 1e-6 * dense.covariance(k, k));
    EXPECT_NEAR(fit->by_pose(k, k), dense.by_pose(k, k), 1e-5 * dense.by_pose(k, k));
  }
}

TEST(ChangeProblem, FitsAsDenseMatricesDo) { expect_dense(20, 1); }
TEST(ChangeProblem, FitsManyReadingsOfAPoseAsDenseMatricesDo) { expect_dense(8, 60); }

}  // namespace
}  // namespace armtrue::change_problem_test
