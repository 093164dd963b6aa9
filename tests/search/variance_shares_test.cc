#include "search/variance_shares.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cstdio>
#include <numeric>

#include "armtrue/campaign/simulation.h"
#include "armtrue/io/robot_io.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/random.h"
#include "armtrue/statistics/summary.h"
#include "search/linearization.h"

namespace armtrue::variance_shares_test {
namespace {

double left_by(const Eigen::MatrixXd& columns, const Eigen::VectorXd& response) {
  return (response - columns * columns.householderQr().solve(response)).squaredNorm();
}

// Plain least squares on all columns at once, the base among them, for every order of entry.
std::vector<double> by_brute_force(const Eigen::MatrixXd& base,
                                   const std::vector<Eigen::MatrixXd>& groups,
                                   const Eigen::VectorXd& response) {
  std::vector<int> order(groups.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<double> shares(groups.size());
  double total = 0;
  do {
    Eigen::MatrixXd columns = base;
    double before = left_by(columns, response);
    for (int g : order) {
      Eigen::MatrixXd more(columns.rows(), columns.cols() + groups[g].cols());
      more << columns, groups[g];
      columns = more;
      const double after = left_by(columns, response);
      shares[g] += before - after;
      total += before - after;
      before = after;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  for (double& share : shares) share /= total;
  return shares;
}

Eigen::MatrixXd random_matrix(Random& random, int rows, int columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

// Plain columns: nothing beside them, every equation a pose of its own.
BesideTheRest plain(const std::vector<Eigen::MatrixXd>& groups, const Eigen::VectorXd& response) {
  const Eigen::Index n = response.size();
  std::vector<int> pose(n);
  std::iota(pose.begin(), pose.end(), 0);
  return {groups, response, Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n), pose, 1};
}

TEST(VarianceShares, AreThoseOfAllOrdersByPlainLeastSquares) {
  Random random(7);
  const Eigen::VectorXd common = random_matrix(random, 40, 1);
  std::vector<Eigen::MatrixXd> groups;
  for (int count : {1, 2, 3, 2}) {
    groups.push_back(random_matrix(random, 40, count));
    groups.back().col(0) += 2 * common;  // what they share is what the order decides about
  }
  const Eigen::VectorXd response = common + 0.3 * random_matrix(random, 40, 1);
  const std::vector<double> expected = by_brute_force(Eigen::MatrixXd(40, 0), groups, response);
  const std::vector<double> shares = variance_shares(plain(groups, response), 1).of_group;
  for (size_t g = 0; g < groups.size(); ++g) EXPECT_NEAR(shares[g], expected[g], 1e-10);
}

TEST(VarianceShares, OfManyGroupsAreDrawnOrdersNearTheTruth) {
  // Pairs of the same column: half the square of their coefficient each.
  std::vector<Eigen::MatrixXd> groups;
  Eigen::VectorXd response = Eigen::VectorXd::Zero(20);
  for (int k = 0; k < 5; ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(20, k);
    groups.insert(groups.end(), {unit, 3 * unit});
    response += (k + 1) * unit;
  }
  const std::vector<double> shares = variance_shares(plain(groups, response), 1).of_group;
  for (int k = 0; k < 5; ++k) {
    // An order and its reverse together give each of the pair its half.
    EXPECT_NEAR(shares[2 * k], 0.5 * (k + 1) * (k + 1) / 55.0, 1e-12);
    EXPECT_NEAR(shares[2 * k + 1], shares[2 * k], 1e-12);
  }
}

// Against the shares with a pose counted a little more, and against campaigns drawn again.
TEST(VarianceShares, HaveTheInfluenceOfEachPoseAndIntervalsThatHold) {
  constexpr int kPoses = 60, kRows = 3 * kPoses, kCampaigns = 400;
  Random random(11);
  const auto draw = [&](int poses, Eigen::VectorXd& response) {
    std::vector<Eigen::MatrixXd> groups{random_matrix(random, 3 * poses, 1),
                                        random_matrix(random, 3 * poses, 2)};
    groups[1].col(0) += 0.7 * groups[0];
    response =
        groups[0] + groups[1] * Eigen::Vector2d(0.5, 0.8) + random_matrix(random, 3 * poses, 1);
    return groups;
  };
  std::vector<int> pose(kRows);
  for (int row = 0; row < kRows; ++row) pose[row] = row / 3;
  Eigen::VectorXd response;
  const std::vector<Eigen::MatrixXd> many = draw(20000, response);
  const double truth = by_brute_force(Eigen::MatrixXd(response.size(), 0), many, response)[0];
  int covered = 0;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    BesideTheRest beside = plain(draw(kPoses, response), response);
    beside.readings = response;
    beside.pose = pose;
    const VarianceShares shares = variance_shares(beside, 1);
    covered += std::abs(shares.of_group[0] - truth) <=
               student_t_975(kPoses - 1) * shares.standard_deviation(Eigen::Vector2d::UnitX());
    if (campaign > 0) continue;
    constexpr double kMore = 1e-5;
    for (int p : {0, 17, 59}) {
      Eigen::VectorXd weight = Eigen::VectorXd::Ones(kRows);
      weight.segment(3 * p, 3).array() += kMore;
      std::vector<Eigen::MatrixXd> weighted;
      for (const Eigen::MatrixXd& group : beside.columns)
        weighted.emplace_back(weight.cwiseSqrt().asDiagonal() * group);
      const std::vector<double> moved = by_brute_force(Eigen::MatrixXd(kRows, 0), weighted,
                                                       weight.cwiseSqrt().cwiseProduct(response));
      for (int group : {0, 1})
        EXPECT_NEAR((moved[group] - shares.of_group[group]) / kMore, shares.influence(p, group),
                    1e-6);
    }
  }
  std::printf("covered: %.3f\n", covered / static_cast<double>(kCampaigns));
  EXPECT_GE(covered, 0.92 * kCampaigns);
  EXPECT_LE(covered, 0.98 * kCampaigns);
}

TEST(VarianceShares, AreZeroWhereNothingIsExplained) {
  const std::vector<Eigen::MatrixXd> groups{Eigen::VectorXd::Unit(3, 0),
                                            Eigen::VectorXd::Unit(3, 1)};
  const Eigen::VectorXd beside = Eigen::VectorXd::Unit(3, 2);
  EXPECT_EQ(variance_shares(plain(groups, beside), 1).of_group, std::vector<double>(2, 0.0));
  EXPECT_TRUE(variance_shares(plain({}, beside), 1).of_group.empty());
}

// Through the linearisation of a fit, against the whitened derivatives themselves.
TEST(VarianceShares, OfAFitAreThoseBesideItsGeometry) {
  const Robot robot = read_robot(ARMTRUE_CONFIG "/robots/kr360-spindle.yaml").robot;
  Robot truth = robot;
  const auto effect = [](const std::string& parameter, DriverKind kind, int joint, double value) {
    Effect one{"hidden", parameter, {kind, joint, -1, ""}, {}, {}};
    one.coefficients.push_back({"c", value, 0, {}});
    return one;
  };
  truth.effects = {effect("A2.theta", DriverKind::gravity_torque, 1, 1e-7),
                   effect("A3.theta", DriverKind::gravity_torque, 2, 2e-7),
                   effect("A5.theta", DriverKind::joint_angle, 4, 3e-4)};
  SimulationOptions options;
  options.poses = 40;
  options.noise_position = 1e-4;
  options.noise_orientation = 1.5e-4;
  const Campaign campaign = simulate(robot, truth, options);
  Robot model = robot;
  model.effects = truth.effects;
  const CalibrationResult fit = calibrate(model, campaign);

  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
  Eigen::MatrixXd blocks = models.blocks();
  const int size = models.row_size(), kept = static_cast<int>(fit.set.kept.size());
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * size, size) *= std::sqrt(fit.weights[row]);
  Eigen::VectorXd response = blocks.rightCols<1>();
  std::vector<Eigen::MatrixXd> groups;
  for (int e = 0; e < 3; ++e) {
    groups.emplace_back(blocks.col(kept + e));
    response += groups.back() * fit.robot.effects[e].coefficients[0].value;
  }
  for (int column = 0; column < kept; ++column) blocks.col(column).normalize();
  for (int first : {0, 1}) {  // the first effect as one of the three, and as declared
    std::vector<Eigen::MatrixXd> traced(groups.begin() + first, groups.end());
    Eigen::MatrixXd base(blocks.rows(), kept + first);
    base << blocks.leftCols(kept), blocks.middleCols(kept, first);
    const std::vector<double> expected = by_brute_force(base, traced, response);
    const std::vector<double> shares =
        variance_shares(Linearization(fit, campaign).effects_from(first), 1).of_group;
    ASSERT_EQ(shares.size(), expected.size());
    for (size_t e = 0; e < shares.size(); ++e) EXPECT_NEAR(shares[e], expected[e], 1e-6);
    EXPECT_GT(*std::min_element(shares.begin(), shares.end()), 0.01);
  }
}

}  // namespace
}  // namespace armtrue::variance_shares_test
