// Many targets and sessions: what a group of rows has of its own is eliminated group by group. The
// same by dense matrices of all rows and unknowns.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/observation/session_models.h"
#include "calibration/column_choice.h"
#include "linear_algebra/sparse_cholesky.h"

namespace armtrue::targets_test {
namespace {

using Split = SessionModels::Split;

Robot shipped(const std::string& name, int targets) {
  Robot robot = read_robot(ARMTRUE_CONFIG "/robots/" + name + ".yaml").robot;
  for (int k = 0; k < targets; ++k) {
    const double turn = 0.7 * k;
    robot.chain.targets.push_back(
        {"T" + std::to_string(k), {0.15 * std::cos(turn), 0.15 * std::sin(turn), 0.01 * k}});
  }
  return robot;
}

// Poses of several sessions, whose instruments stood apart.
Campaign measured(int poses, int targets, int sessions, int repeats = 1) {
  SimulationOptions options;
  options.poses = poses;
  options.repeats = repeats;
  options.noise_position = 1e-4;
  Campaign campaign =
      simulate(shipped("kr360-spindle", targets), shipped("kr360-table4", targets), options);
  if (sessions == 1) return campaign;
  for (int s = 0; s < sessions; ++s) campaign.session_names.push_back("day " + std::to_string(s));
  for (int row = 0; row < campaign.rows(); ++row) {
    const int s = campaign.session.emplace_back(campaign.pose[row] % sessions);
    campaign.position[row] =
        rotation_exp({0.01 * s, 0, 0.5 * s}) * campaign.position[row] + Eigen::Vector3d(s, 0, 0);
  }
  return campaign;
}

std::vector<int> in_order(const Robot& robot) {
  const ParameterLayout layout = layout_of(robot.chain);
  std::vector<int> order;
  for (int k = 0; k < kFirstLinkParameter; ++k) order.push_back(k);
  for (int k = layout.targets; k < first_anchor_parameter(robot.chain); ++k) order.push_back(k);
  for (int k = layout.tool; k < layout.geometric; ++k) order.push_back(k);
  for (int k = kFirstLinkParameter; k < layout.tool; ++k) order.push_back(k);
  return order;
}

// The same by least squares on the columns kept before, one column after another.
IdentifiableSet by_least_squares(const SessionModels& models, const std::vector<int>& order) {
  const Eigen::MatrixXd blocks = models.blocks();
  const Eigen::Index own = models.unknowns() - std::ssize(order);
  Eigen::MatrixXd kept = blocks.middleCols(std::ssize(order), own);
  IdentifiableSet set;
  std::vector<int> parameters;
  for (size_t k = 0; k < order.size(); ++k) {
    const Eigen::VectorXd column = blocks.col(static_cast<Eigen::Index>(k));
    const Eigen::VectorXd solution = kept.cols() > 0
                                         ? Eigen::VectorXd(kept.colPivHouseholderQr().solve(column))
                                         : Eigen::VectorXd(0);
    if (column.norm() > 1e-12 && (column - kept * solution).norm() > 1e-6 * column.norm()) {
      kept.conservativeResize(column.size(), kept.cols() + 1);
      kept.rightCols<1>() = column;
      parameters.push_back(order[k]);
      continue;
    }
    AbsorbedParameter& absorbed = set.absorbed.emplace_back(AbsorbedParameter{order[k]});
    for (size_t i = 0; i < parameters.size() && column.norm() > 1e-12; ++i)
      if (const double share = solution[own + static_cast<Eigen::Index>(i)]; std::abs(share) > 1e-4)
        absorbed.absorbed_by.emplace_back(parameters[i], share);
  }
  std::ranges::sort(parameters);
  set.kept = parameters;
  return set;
}

void expect_same(const IdentifiableSet& found, const IdentifiableSet& expected) {
  EXPECT_EQ(found.kept, expected.kept);
  std::map<int, std::map<int, double>> shares;
  for (const AbsorbedParameter& absorbed : found.absorbed)
    shares[absorbed.parameter] = {absorbed.absorbed_by.begin(), absorbed.absorbed_by.end()};
  ASSERT_EQ(shares.size(), expected.absorbed.size());
  for (const AbsorbedParameter& absorbed : expected.absorbed) {
    const std::map<int, double>& own = shares.at(absorbed.parameter);
    EXPECT_EQ(own.size(), absorbed.absorbed_by.size()) << absorbed.parameter;
    for (const auto& [parameter, share] : absorbed.absorbed_by)
      EXPECT_NEAR(own.contains(parameter) ? own.at(parameter) : 0, share,
                  1e-5 * (1 + std::abs(share)))
          << absorbed.parameter << " by " << parameter;
  }
}

struct Case {
  int poses, targets, sessions;
};

class ColumnsOfTargets : public testing::TestWithParam<Case> {};

TEST_P(ColumnsOfTargets, AreThoseThatLeastSquaresFindIndependent) {
  const auto [poses, targets, sessions] = GetParam();
  const Robot robot = shipped("kr360-spindle", targets);
  const Campaign campaign = measured(poses, targets, sessions);
  const std::vector<int> order = in_order(robot);
  const SessionModels split(campaign, robot, order, {1, 1}, kAllEffects, Split::by_target);
  ASSERT_TRUE(split.is_split_by_target());
  EXPECT_EQ(split.groups(), targets * sessions);
  const SessionModels whole(campaign, robot, order, {1, 1});
  const IdentifiableSet expected = by_least_squares(whole, order);
  expect_same(choose_columns(split, robot.chain), expected);
  expect_same(choose_columns(whole, robot.chain), expected);
}

// In one pose the targets together imitate the base, and the last ones are absorbed by it; in two
// poses they do so by half.
INSTANTIATE_TEST_SUITE_P(Targets, ColumnsOfTargets,
                         testing::Values(Case{8, 25, 1}, Case{1, 25, 1}, Case{2, 25, 1},
                                         Case{8, 25, 2}));

Eigen::MatrixXd dense_covariance(const SessionModels& models, const CalibrationResult& fit) {
  const Eigen::MatrixXd blocks = models.blocks();
  const Eigen::Index p = models.unknowns(), size = models.row_size();
  const Eigen::MatrixXd jacobian = blocks.leftCols(p);
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  information.diagonal() += fit.prior_weight.cwiseAbs2();
  const Eigen::MatrixXd inverse = information.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
  const std::vector<int>& pose = models.campaign().pose;
  const int poses = 1 + *std::ranges::max_element(pose);
  Eigen::MatrixXd changes(p, poses);
  for (int k = 0; k < poses; ++k) {
    std::vector<Eigen::Index> own;
    for (Eigen::Index row = 0; row < std::ssize(pose); ++row)
      for (Eigen::Index i = 0; pose[static_cast<size_t>(row)] == k && i < size; ++i)
        own.push_back(row * size + i);
    const Eigen::MatrixXd rows = jacobian(own, Eigen::all);
    const Eigen::VectorXd residual = blocks.col(p)(own);
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(rows.rows(), rows.rows()) - rows * inverse * rows.transpose();
    changes.col(k) = inverse * rows.transpose() * left.ldlt().solve(residual);
  }
  const Eigen::VectorXd mean = changes.rowwise().mean();
  const Eigen::MatrixXd off = changes.colwise() - mean;
  const double n = poses;
  return (n - 1) / n * off * off.transpose() +
         inverse * fit.prior_weight.cwiseAbs2().asDiagonal() * inverse;
}

class FitOfTargets : public testing::TestWithParam<Case> {};

TEST_P(FitOfTargets, IsThatOfDenseMatrices) {
  const auto [poses, targets, sessions] = GetParam();
  Robot robot = shipped("kr360-spindle", targets);
  for (Target& target : robot.chain.targets) target.position.setZero();
  const Campaign campaign = measured(poses, targets, sessions, 2);
  CalibrationOptions options;
  options.robust = false;
  options.tolerance = 1e-14;
  const IdentifiableSet set = choose_identifiable(robot, campaign);
  // The second fit starts at the solution of the first, so that turns of base and tool are zero.
  const CalibrationResult first = calibrate(robot, campaign, set, options);
  const CalibrationResult fit = calibrate(first.robot, campaign, set, options);
  EXPECT_TRUE(fit.converged);
  const SessionModels models(campaign, fit.robot, set.kept, fit.sigma);
  ASSERT_EQ(models.unknowns(), std::ssize(fit.names));
  EXPECT_EQ(models.unknown_names(), fit.names);
  EXPECT_EQ(fit.rank, models.unknowns());

  const Eigen::MatrixXd blocks = models.blocks();
  const Eigen::Index p = models.unknowns();
  const Eigen::MatrixXd jacobian = blocks.leftCols(p);
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  const Eigen::MatrixXd of_rows = information;
  information.diagonal() += fit.prior_weight.cwiseAbs2();
  const Eigen::VectorXd gradient =
      jacobian.transpose() * blocks.col(p) + fit.prior_weight.cwiseProduct(fit.prior_residual);
  const Eigen::MatrixXd inverse = information.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
  const Eigen::MatrixXd covariance = dense_covariance(models, fit);
  const Eigen::VectorXd step = inverse * gradient;
  const Eigen::MatrixXd by_root = fit.inverse_root * fit.inverse_root.transpose();
  for (Eigen::Index k = 0; k < p; ++k) {
    const double deviation = std::sqrt(inverse(k, k));
    EXPECT_NEAR(step[k], 0, 1e-4 * deviation) << fit.names[static_cast<size_t>(k)];
    for (Eigen::Index i = 0; i < p; ++i) {
      EXPECT_NEAR(by_root(k, i), inverse(k, i), 1e-6 * deviation * std::sqrt(inverse(i, i)));
      EXPECT_NEAR(fit.covariance(k, i), covariance(k, i),
                  1e-6 * std::sqrt(covariance(k, k) * covariance(i, i)))
          << fit.names[static_cast<size_t>(k)] << ", " << fit.names[static_cast<size_t>(i)];
    }
  }
  const Eigen::VectorXd singular =
      Eigen::MatrixXd(jacobian).jacobiSvd().singularValues() * fit.sigma.position;
  EXPECT_NEAR(fit.condition, singular[0] / singular[p - 1], 1e-5 * fit.condition);
  EXPECT_NEAR(fit.observability[4], 1 / singular.cwiseInverse().sum(), 1e-5 * fit.observability[4]);
  if (sessions > 1) return;
  // The largest variance of a reading's position.
  double largest = 0;
  for (Eigen::Index row = 0; row < campaign.rows(); ++row)
    largest = std::max(largest,
                       (fit.sigma.position * fit.sigma.position * jacobian.middleRows(3 * row, 3) *
                        covariance * jacobian.middleRows(3 * row, 3).transpose())
                           .trace());
  EXPECT_NEAR(uncertainty_of(fit, campaign).largest_variance, largest, 1e-6 * largest);
}

INSTANTIATE_TEST_SUITE_P(Targets, FitOfTargets,
                         testing::Values(Case{30, 15, 1}, Case{30, 15, 2}, Case{24, 1, 3}));

// Models of one target each against one of all: also of distances, where the places of the anchors
// stand behind those of the targets, and with an effect that moves a target.
TEST(ModelsOfOneTarget, EqualThatOfAll) {
  for (const bool moves : {false, true}) {
    Robot robot = shipped("kr360-spindle", 12);
    robot.chain.anchors = {{"1", {2.5, 1.5, 0.1}}, {"2", {2.5, -1.5, 0.3}}};
    if (moves) {
      Effect& effect = robot.effects.emplace_back();
      effect.name = "shift";
      effect.parameter = "target T7.y";
      effect.driver.joint = 1;
      effect.shape.kind = ShapeKind::linear;
      effect.coefficients = {{"c", 1e-4}};
    }
    const Campaign campaign = simulate(robot, robot, {.poses = 9, .noise_position = 1e-4});
    ASSERT_TRUE(campaign.reads_one_number());
    const ParameterLayout layout = layout_of(robot.chain);
    std::vector<int> order(static_cast<size_t>(parameter_count(robot.chain) - layout.targets));
    std::iota(order.begin(), order.end(), layout.targets);
    order.push_back(kFirstBaseParameter);
    const SessionModels split(campaign, robot, order, {1, 1}, kAllEffects, Split::by_target);
    const SessionModels whole(campaign, robot, order, {1, 1});
    ASSERT_TRUE(split.is_split_by_target());
    EXPECT_LT((split.blocks() - whole.blocks()).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(whole.unknowns(), 1e-3, 2e-3);
    const Robot moved = split.robot_at(x), expected = whole.robot_at(x);
    EXPECT_LT((moved.chain.base.translation - expected.chain.base.translation).norm(), 1e-15);
    ASSERT_EQ(moved.chain.targets.size(), 12U);
    for (size_t k = 0; k < 12; ++k)
      EXPECT_EQ(moved.chain.targets[k].position, expected.chain.targets[k].position);
    for (size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(moved.chain.anchors[k].position, expected.chain.anchors[k].position);
      EXPECT_EQ(moved.chain.anchors[k].zero, expected.chain.anchors[k].zero);
    }
    for (int row = 0; row < campaign.rows(); row += 5)
      EXPECT_NEAR(split.squared_norms(x)[static_cast<size_t>(row)][0],
                  whole.squared_norms(x)[static_cast<size_t>(row)][0], 1e-12);
  }
}

// Own unknowns of groups, which meet only the common ones.
TEST(SparseCholesky, InvertsWhatGroupsHaveOfTheirOwn) {
  constexpr int kGroups = 100, kOwn = 3, kCommon = 8, kSize = kGroups * kOwn + kCommon;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(kSize, kSize);
  for (int g = 0; g < kGroups; ++g) {
    std::vector<int> unknowns(kOwn + kCommon);  // the common ones stand in the middle
    std::iota(unknowns.begin() + kOwn, unknowns.end(), 50);
    for (int k = 0; k < kOwn; ++k)
      unknowns[static_cast<size_t>(k)] = (g * kOwn + k) + (g * kOwn + k >= 50 ? kCommon : 0);
    const Eigen::MatrixXd rows =
        Eigen::MatrixXd::NullaryExpr(12, kOwn + kCommon, [&] { return normal(random); });
    matrix(unknowns, unknowns) += rows.transpose() * rows;
  }
  EXPECT_TRUE(is_sparse(matrix));
  const SparseCholesky sparse(matrix);
  ASSERT_TRUE(sparse.succeeded());
  const Eigen::MatrixXd root = sparse.inverse_root();
  const Eigen::MatrixXd identity = root * root.transpose() * matrix;
  EXPECT_LT((identity - Eigen::MatrixXd::Identity(kSize, kSize)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(sparse.inverse_root().nonZeros(), kSize * (2 * kOwn + kCommon));
  EXPECT_GT(sparse.smallest_pivot(), 0.1);
  // With more on the diagonal.
  const Eigen::VectorXd added = Eigen::VectorXd::LinSpaced(kSize, 0, 5);
  Eigen::MatrixXd more = matrix;
  more.diagonal() += added;
  const Eigen::MatrixXd inverse = more.ldlt().solve(Eigen::MatrixXd::Identity(kSize, kSize));
  const SparseCholesky of_more(matrix, added);
  for (Eigen::Index k = 0; k < kSize; k += 7)
    EXPECT_NEAR(of_more.variance(k), inverse(k, k), 1e-9 * inverse(k, k));
  matrix(0, 0) = -1;
  EXPECT_FALSE(SparseCholesky(matrix).succeeded());
  EXPECT_FALSE(is_sparse(Eigen::MatrixXd::Ones(300, 300)));
}

}  // namespace
}  // namespace armtrue::targets_test
