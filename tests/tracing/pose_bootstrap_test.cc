#include "armtrue/calibration/pose_bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "armtrue/io/robot_io.h"
#include "armtrue/statistics/random.h"
#include "search/linearization.h"
#include "tracing/hidden_campaign.h"

namespace armtrue::pose_bootstrap_test {
namespace {

const std::string kNominal = ARMTRUE_CONFIG "/robots/kr360-spindle.yaml";

// The nominal robot with the hidden effect declared, of no size.
Robot with_effect_of(const HiddenCampaign& campaign) {
  Robot robot = read_robot(kNominal).robot;
  const armtrue_oracle::Hidden& truth = campaign.written.truth;
  robot.effects = {{truth.family, truth.parameter, *parse_driver(truth.driver), {}, {{}}}};
  return robot;
}

const Coefficient& first_coefficient(const CalibrationResult& fit) {
  return fit.robot.effects.at(0).coefficients.at(0);
}

CalibrationResult with_intervals_by_pose(CalibrationResult fit, const Campaign& campaign) {
  set_intervals(bootstrap_coefficients(fit, campaign, 1000, 1),
                static_cast<int>(campaign.pose_ids.size()), fit.robot);
  return fit;
}

TEST(PercentileInterval, OfAMeanIsAsWideAsStudents) {
  // With Student's quantile of 97.5 %, from tables.
  for (const auto& [poses, quantile] : {std::pair{8, 2.364624}, {15, 2.144787}, {60, 2.000995}}) {
    Random random(3);
    Eigen::VectorXd values(poses);
    for (double& value : values) value = random.normal();
    values.array() -= values.mean();
    const double deviation = std::sqrt(values.squaredNorm() / (poses - 1));
    const double half_width = quantile * deviation / std::sqrt(poses);
    const Eigen::VectorXd means = drawn_sums(values, 20000, 1) / poses;
    const auto [low, high] = percentile_interval({means.begin(), means.end()}, poses);
    // The law of so few values has lighter tails than the normal law.
    EXPECT_NEAR(0.5 * (high - low), half_width, 0.06 * half_width) << poses;
  }
  EXPECT_EQ(percentile_interval({1, 2, 3}, 1), (std::array<double, 2>{0, 0}));
}

TEST(DrawnSums, AreOfAsManyPosesAsThereAre) {
  const Eigen::MatrixXd each = Eigen::MatrixXd::Identity(7, 7);
  const Eigen::MatrixXd drawn = drawn_sums(each, 200, 1);
  EXPECT_EQ(drawn.rowwise().sum(), Eigen::VectorXd::Constant(200, 7));
  EXPECT_EQ(drawn, drawn_sums(each, 200, 1));
  EXPECT_NE(drawn, drawn_sums(each, 200, 2));
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(7, 1, 7);
  EXPECT_EQ(drawn_sums(values, 200, 1), drawn * values);
}

// Against the jackknife proper: a whole fit without each of the poses.
TEST(PoseBootstrap, AgreesWithFitsWithoutEachPose) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = 21;
  plan.poses = 30;
  plan.known_masses = true;
  plan.rest_mrad = 0.05;
  const HiddenCampaign hidden(kNominal, "compliance", 0.06, plan);
  const Campaign& campaign = hidden.training;
  CalibrationOptions options;
  options.robust = false;  // weights that the refits share
  const CalibrationResult fit = calibrate(with_effect_of(hidden), campaign, options);
  const double whole = first_coefficient(fit).value;
  std::vector<double> changes;
  double mean = 0;
  for (int pose = 0; pose < plan.poses; ++pose) {
    std::vector<int> rows;
    for (int row = 0; row < campaign.rows(); ++row)
      if (campaign.pose[row] != pose) rows.push_back(row);
    const Campaign others = campaign.select(rows);
    changes.push_back(first_coefficient(calibrate(fit.robot, others, fit.set, options)).value -
                      whole);
    mean += changes.back() / plan.poses;
  }
  double squares = 0;
  for (double change : changes) squares += (change - mean) * (change - mean);
  const double jackknife = std::sqrt(squares * (plan.poses - 1) / plan.poses);
  EXPECT_NEAR(first_coefficient(fit).std, jackknife, 0.05 * jackknife);
  const Eigen::VectorXd draws = bootstrap_coefficients(fit, campaign, 1000, 1).col(0);
  EXPECT_NEAR(std::sqrt(draws.squaredNorm() / 1000), jackknife, 0.08 * jackknife);
}

// The standard deviation of an unknown if readings erred independently of each other.
double independent_std(const CalibrationResult& fit, Eigen::Index unknown) {
  return fit.inverse_root.row(unknown).norm();
}

// The arm comes to rest elsewhere in each pose, the same at every return: what the replicates do
// not show makes the covariance of the fit too small.
TEST(PoseBootstrap, HoldsTheTruthWhereReadingsOfAPoseErrAlike) {
  constexpr int kCampaigns = 40;
  int plain = 0, student = 0, by_pose = 0;
  for (unsigned seed = 400; seed < 400 + kCampaigns; ++seed) {
    armtrue_oracle::CampaignPlan plan;
    plan.seed = seed;
    plan.poses = 30;
    plan.known_masses = true;
    plan.rest_mrad = 0.05;
    const HiddenCampaign hidden(kNominal, "compliance", 0.06, plan);
    const double truth = 1e-6 * hidden.written.amplitude;  // the oracle's unit effect
    const CalibrationResult fit = calibrate(with_effect_of(hidden), hidden.training);
    const auto holds = [&](const CalibrationResult& of) {
      const auto [low, high] = first_coefficient(of).ci95;
      return low <= truth && truth <= high;
    };
    const auto coefficient = static_cast<Eigen::Index>(fit.set.kept.size());
    plain += std::abs(first_coefficient(fit).value - truth) <=
             1.959964 * independent_std(fit, coefficient);
    student += holds(fit);
    by_pose += holds(with_intervals_by_pose(fit, hidden.training));
  }
  // Binomial(40, 0.95): 34 or more but once in a hundred; of all but one in ten thousand below 40.
  EXPECT_GE(student, 34);
  EXPECT_GE(by_pose, 34);
  EXPECT_LE(plain, 33);
}

armtrue_oracle::CampaignPlan resting(unsigned seed, double rest_mrad) {
  armtrue_oracle::CampaignPlan plan;
  plan.seed = seed;
  plan.rest_mrad = rest_mrad;
  return plan;
}

// Geometry found from what the same arm reads without any error is the truth.
TEST(CovarianceByPose, IsThatOfTheGeometryWhereReadingsOfAPoseErrAlike) {
  constexpr int kCampaigns = 15;
  double by_pose = 0, independent = 0;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    armtrue_oracle::CampaignPlan exact = resting(seed, 0);
    exact.noise_mm = exact.noise_mrad = 0;
    const HiddenCampaign without_error(kNominal, "null", 0, exact);
    const HiddenCampaign measured(kNominal, "null", 0, resting(seed, 0.05));
    const CalibrationResult truth = calibrate(read_robot(kNominal).robot, without_error.training);
    const CalibrationResult fit = calibrate(truth.robot, measured.training, truth.set);
    for (Eigen::Index k = 0; k < fit.change.size(); ++k) {
      const double count = static_cast<double>(fit.change.size()) * kCampaigns;
      by_pose += std::pow(fit.change[k], 2) / (fit.covariance(k, k) * count);
      independent += std::pow(fit.change[k] / independent_std(fit, k), 2) / count;
    }
  }
  // Mean squares of errors in units of their standard deviation.
  std::printf("by pose %.2f, independent %.2f\n", by_pose, independent);
  EXPECT_NEAR(by_pose, 1, 0.2);
  EXPECT_GT(independent, 1.5);
}

// As the frequency of a cycle is: one more unknown beside those of the fit, here of no size.
TEST(CovarianceByPose, IsThatOfOneMoreColumn) {
  constexpr int kCampaigns = 40;
  double by_pose = 0, alike = 0;
  for (unsigned seed = 1; seed <= kCampaigns; ++seed) {
    const HiddenCampaign hidden(kNominal, "null", 0, resting(seed, 0.05));
    const CalibrationResult fit = calibrate(read_robot(kNominal).robot, hidden.training);
    const Linearization near(fit, hidden.training);
    Eigen::VectorXd column = near.jacobian().col(*find_parameter(fit.robot.chain, "A2.theta"));
    for (int row = 0; row < near.rows(); ++row) {
      const int reading = near.replicates().reading[near.replicates().first[row]];
      column.segment(row * near.row_size(), near.row_size()) *=
          std::sin(9 * hidden.training.q[reading][1]);
    }
    const Eigen::VectorXd beside = column - near.basis() * (near.basis().transpose() * column);
    const double estimate = beside.dot(near.residual()) / beside.squaredNorm();
    by_pose += std::pow(estimate / near.standard_deviation(column), 2) / kCampaigns;
    // All directions widened alike by how far readings of a pose agree (Kish 1965).
    const double variance = near.residual_norm() / near.residual_freedom() / beside.squaredNorm();
    alike += estimate * estimate / variance / kCampaigns;
  }
  // Mean of 40 squares: of a normal law 1 +- 0.45 in 95 of 100 cases.
  std::printf("one more column: by pose %.2f, all alike %.2f\n", by_pose, alike);
  EXPECT_NEAR(by_pose, 1, 0.45);
  EXPECT_GT(alike, 1.5);
}

// A session of a single pose shows its base, and nobody else does: no scatter between poses says
// how well.
TEST(CovarianceByPose, OfWhatOnePoseShowsAloneIsThatOfItsReadings) {
  HiddenCampaign hidden(kNominal, "null", 0, resting(3, 0.05));
  Campaign& campaign = hidden.training;
  campaign.session_names = {"day 1", "day 2"};
  for (int pose : campaign.pose) campaign.session.push_back(pose == 7 ? 1 : 0);
  const CalibrationResult fit = calibrate(read_robot(kNominal).robot, campaign);
  ASSERT_EQ(fit.names.back(), "session day 2 base.rz");
  for (Eigen::Index k = fit.change.size() - 6; k < fit.change.size(); ++k) {
    const double by_pose = std::sqrt(fit.covariance(k, k));
    EXPECT_GT(by_pose, 0.9 * independent_std(fit, k)) << fit.names[k];
    EXPECT_LT(by_pose, 2 * independent_std(fit, k)) << fit.names[k];
  }
}

// What readings cannot show is as uncertain as it was before them.
TEST(CovarianceByPose, HoldsPriorKnowledge) {
  Robot robot = read_robot(kNominal).robot;
  robot.identify = {"base", "A2.d", "A2.theta", "A3.beta"};
  robot.priors = {{"A3.beta", 1e-9}};
  const HiddenCampaign hidden(kNominal, "null", 0, resting(3, 0.05));
  EXPECT_NEAR(calibrate(robot, hidden.training).robot.std.at("A3.beta"), 1e-9, 1e-12);
}

}  // namespace
}  // namespace armtrue::pose_bootstrap_test
