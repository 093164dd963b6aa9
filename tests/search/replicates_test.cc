// Replicates as one row of a linear problem against the same readings as rows of their own: every
// figure of the search is the same.

#include "search/replicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "search/cross_validation.h"
#include "search/linear_problem.h"
#include "search/variance_shares.h"

namespace armtrue::replicates_test {
namespace {

constexpr int kPoses = 24, kRepeats = 5, kReadings = kPoses * kRepeats, kSize = 3;
constexpr int kGeometric = 4;

Candidate by(DriverKind kind, int joint, const std::string& parameter,
             ShapeKind shape = ShapeKind::linear) {
  Candidate candidate = candidate_of(parameter, joint, shape);
  candidate.effect.driver.kind = kind;
  return candidate;
}

// Rounds of visits: a time of its own for each reading, and a direction that changes from round to
// round. Weights as a robust fit gives them, one of them to a blunder.
struct Readings {
  Random random{11};
  Campaign campaign;
  LinearProblem apart, merged;
  std::vector<Candidate> candidates{
      candidate_of("A3.theta", 0),  // the same at every visit
      candidate_of("base", 3),
      by(DriverKind::time, -1, "A2.theta"),
      by(DriverKind::time, -1, "base"),
      by(DriverKind::arrival, 1, "A2.theta", ShapeKind::sign),
      candidate_of("A4.alpha", 4, ShapeKind::harmonic),  // times the time
  };

  Readings() {
    candidates.back().effect.driver.factor = DriverKind::time;
    const Campaign poses = angles_by_hand(random, kPoses);
    campaign.pose_ids = poses.pose_ids;
    for (int reading = 0; reading < kReadings; ++reading) {
      const int pose = pose_of(reading);
      campaign.pose.push_back(pose);
      campaign.q.push_back(poses.q[pose]);
      campaign.position.emplace_back(0, 0, 0);
      campaign.time_s.push_back(20.0 * reading + random.uniform(0, 10));
      campaign.arrival.emplace_back();
      for (int joint = 0; joint < 6; ++joint)
        campaign.arrival.back()[joint] = random.uniform(-1, 1) > 0 ? 1 : -1;
    }
    const LinearProblem of_poses = problem_by_hand(random, poses, kGeometric);
    Eigen::VectorXd root(kReadings);
    for (double& one : root) one = std::sqrt(random.uniform(0.6, 1.2));
    root[7] = 0.05;
    apart = of_poses;
    apart.pose = campaign.pose;
    apart.jacobian.resize(kReadings * kSize, of_poses.jacobian.cols());
    apart.fitted.resize(kReadings * kSize, kGeometric + 1);
    for (int reading = 0; reading < kReadings; ++reading) {
      const int pose = pose_of(reading), effect = parameter_by_hand("A5.theta");
      const auto own = of_poses.jacobian.middleRows<kSize>(kSize * pose);
      apart.jacobian.middleRows<kSize>(kSize * reading) = root[reading] * own;
      apart.fitted.middleRows<kSize>(kSize * reading)
          << root[reading] * of_poses.fitted.middleRows<kSize>(kSize * pose),
          root[reading] * std::sin(poses.q[pose][2]) * own.col(effect);
    }
    apart.readings = normal_matrix(random, kReadings * kSize, 1);
    for (int reading = 0; reading < kReadings; ++reading)  // of the third and the fifth candidate
      apart.readings.segment<kSize>(kSize * reading) +=
          (0.002 * campaign.time_s[reading] + 1.5 * campaign.arrival[reading][1]) *
          apart.jacobian.col(parameter_by_hand("A2.theta")).segment<kSize>(kSize * reading);
    apart.coefficients_of_effect = {{0.4}};
    merge(root);
  }

  static int pose_of(int reading) { return (5 * reading + reading / kPoses) % kPoses; }

  // The rotation of the equations of a pose by hand.
  void merge(const Eigen::VectorXd& root) {
    merged = apart;
    merged.pose.resize(kPoses);
    std::iota(merged.pose.begin(), merged.pose.end(), 0);
    merged.jacobian.setZero(kPoses * kSize, apart.jacobian.cols());
    merged.fitted.setZero(kPoses * kSize, apart.fitted.cols());
    merged.readings.setZero(kPoses * kSize);
    Replicates& replicates = merged.replicates;
    replicates.first = {0};
    replicates.rest.resize(kSize, kReadings);
    for (int pose = 0; pose < kPoses; ++pose) {
      std::vector<int> own;
      for (int reading = 0; reading < kReadings; ++reading)
        if (pose_of(reading) == pose) own.push_back(reading);
      double squares = 0;
      for (int reading : own) squares += root[reading] * root[reading];
      auto readings = merged.readings.segment<kSize>(kSize * pose);
      for (int reading : own) {
        const double share = root[reading] / std::sqrt(squares);
        merged.jacobian.middleRows<kSize>(kSize * pose) +=
            share * apart.jacobian.middleRows<kSize>(kSize * reading);
        merged.fitted.middleRows<kSize>(kSize * pose) +=
            share * apart.fitted.middleRows<kSize>(kSize * reading);
        readings += share * apart.readings.segment<kSize>(kSize * reading);
        replicates.reading.push_back(reading);
        replicates.share.push_back(share);
      }
      for (int k = replicates.first.back(); k < replicates.readings(); ++k)
        replicates.rest.col(k) = apart.readings.segment<kSize>(kSize * replicates.reading[k]) -
                                 replicates.share[k] * readings;
      replicates.first.push_back(replicates.readings());
    }
  }
};

void expect_alike(const std::vector<CandidateScore>& one,
                  const std::vector<CandidateScore>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].degrees_of_freedom, other[k].degrees_of_freedom) << k;
    EXPECT_NEAR(one[k].gain, other[k].gain, 1e-5 * (1 + other[k].gain)) << k;
    EXPECT_NEAR(one[k].score, other[k].score, 1e-4 * (1 + std::abs(other[k].score))) << k;
    EXPECT_NEAR(one[k].unexplained_share, other[k].unexplained_share, 1e-5) << k;
    EXPECT_LT((one[k].coefficients - other[k].coefficients).norm(),
              1e-4 * (1e-9 + other[k].coefficients.norm()))
        << k;
  }
}

class ReplicatesTest : public testing::Test {
 protected:
  Readings readings_;
  Linearization merged_{readings_.merged}, apart_{readings_.apart};
  CandidateScan scan_{readings_.candidates, robot_by_hand(), readings_.campaign};
  ProjectedCandidates of_merged_{scan_, merged_}, of_apart_{scan_, apart_};
};

TEST_F(ReplicatesTest, AreSufficientForTheScan) {
  ASSERT_EQ(merged_.rows(), kPoses);
  ASSERT_EQ(apart_.rows(), kReadings);
  EXPECT_NEAR(merged_.residual_norm(), apart_.residual_norm(), 1e-10 * apart_.residual_norm());
  EXPECT_EQ(merged_.residual_freedom(), apart_.residual_freedom());
  expect_alike(of_merged_.scores(), of_apart_.scores());
  EXPECT_GT(of_apart_.scores()[2].score, 20);  // that of the time
  EXPECT_GT(of_apart_.scores()[4].score, 20);  // and of the direction
}

TEST_F(ReplicatesTest, AreSufficientForTheScanInThePlaceOfAnEffect) {
  const auto merged = of_merged_.in_place_of(0), apart = of_apart_.in_place_of(0);
  expect_alike(merged.scores, apart.scores);
  for (size_t k = 0; k < apart.imitations.size(); ++k)
    EXPECT_NEAR(merged.imitations[k].gain, apart.imitations[k].gain, 1e-5) << k;
}

TEST_F(ReplicatesTest, AreSufficientForTheSignFlips) {
  const std::vector<double> merged = of_merged_.best_of_flipped(99, 3);
  const std::vector<double> apart = of_apart_.best_of_flipped(99, 3);
  for (size_t k = 0; k < apart.size(); ++k)
    EXPECT_NEAR(merged[k], apart[k], 1e-3 * (1 + std::abs(apart[k]))) << k;
}

TEST_F(ReplicatesTest, AreSufficientForTheCrossValidation) {
  const CrossValidation of_merged(merged_, 5), of_apart(apart_, 5);
  for (int candidate = 0; candidate < 6; ++candidate) {
    const GainLeftOut merged = of_merged.of(of_merged_.directions(candidate));
    const GainLeftOut apart = of_apart.of(of_apart_.directions(candidate));
    EXPECT_NEAR(merged.gain, apart.gain, 1e-6) << candidate;
    EXPECT_NEAR(merged.error, apart.error, 1e-6) << candidate;
  }
  const GainLeftOut merged = of_merged.of_effect(0), apart = of_apart.of_effect(0);
  EXPECT_NEAR(merged.gain, apart.gain, 1e-9);
  EXPECT_NEAR(merged.error, apart.error, 1e-9);
}

TEST_F(ReplicatesTest, AreSufficientForStandardDeviationsAndShares) {
  const int parameter = parameter_by_hand("A6.theta");
  const double merged = merged_.standard_deviation(merged_.jacobian().col(parameter));
  EXPECT_NEAR(merged, apart_.standard_deviation(apart_.jacobian().col(parameter)), 1e-9 * merged);
  const VarianceShares shares = variance_shares(merged_.effects_from(0), 1);
  const VarianceShares expected = variance_shares(apart_.effects_from(0), 1);
  EXPECT_LT((shares.influence - expected.influence).norm(), 1e-9);
}

// At every reading again, as the predictor takes them, and their products without them.
TEST_F(ReplicatesTest, ColumnsAtReadingsAreThoseOfReadingsApart) {
  const Eigen::VectorXd v =
      Eigen::VectorXd::LinSpaced(scan_.columns_at_readings(apart_, 0).rows(), -1, 2).array().sin();
  const Eigen::VectorXd products = scan_.products_at_readings(merged_, v);
  Eigen::Index first = 0;
  for (int candidate = 0; candidate < static_cast<int>(scan_.candidates().size()); ++candidate) {
    const Eigen::MatrixXd apart = scan_.columns_at_readings(apart_, candidate);
    EXPECT_LT((scan_.columns_at_readings(merged_, candidate) - apart).norm(), 1e-12 * apart.norm());
    const Eigen::VectorXd own = products.segment(first, apart.cols());
    EXPECT_LT((own - apart.transpose() * v).norm(), 1e-10 * apart.norm() * v.norm()) << candidate;
    first += apart.cols();
  }
  EXPECT_EQ(first, products.size());
}

}  // namespace
}  // namespace armtrue::replicates_test
