#include "armtrue/statistics/summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "armtrue/statistics/intervals.h"

namespace armtrue::summary_test {
namespace {

TEST(Statistics, SummaryOfAKnownSample) {
  const ErrorSummary summary = summarize({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(summary.mean, 2.5);
  EXPECT_DOUBLE_EQ(summary.rms, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(summary.p95, 3.85);
  EXPECT_DOUBLE_EQ(summary.max, 4);
}

TEST(Statistics, SummaryIsThatOfSortedErrors) {
  std::mt19937_64 random(6);
  std::exponential_distribution<double> exponential;
  for (size_t count : {1, 2, 21, 1000}) {
    std::vector<double> errors(count);
    for (double& error : errors) error = exponential(random);
    const ErrorSummary summary = summarize(errors);
    std::ranges::sort(errors);
    const double place = 0.95 * static_cast<double>(count - 1);
    const auto below = static_cast<size_t>(place);
    const double above = errors[std::min(below + 1, count - 1)];
    const double share = place - static_cast<double>(below);
    EXPECT_DOUBLE_EQ(summary.p95, errors[below] + share * (above - errors[below])) << count;
    EXPECT_EQ(summary.max, errors.back()) << count;
  }
}

TEST(Statistics, QuantileIsAnOrderStatistic) {
  const std::vector<double> values{7, 1, 9, 3, 5};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.5), 5);
  EXPECT_EQ(quantile(values, 0.9), 7);  // place 3.6
  EXPECT_EQ(quantile(values, 1), 9);
}

TEST(Statistics, MeanOfNumbersAndOfMembers) {
  struct Item {
    Eigen::Vector2d place;
  };
  const std::vector<Item> items{{{1, 4}}, {{2, 0}}, {{6, 2}}};
  EXPECT_EQ(mean_of(items, &Item::place), Eigen::Vector2d(3, 2));
  EXPECT_EQ(mean_of(items, [](const Item& item) { return item.place.x() * item.place.y(); }),
            16.0 / 3);
}

TEST(Statistics, MedianOfNothingIsAnError) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_THROW(median({}), std::invalid_argument);
  EXPECT_EQ(robust_deviation({}), 0);
}

// The table of chi-square with three degrees of freedom.
TEST(Statistics, LengthOfThreeNormalComponents) {
  EXPECT_NEAR(normal_length_exceeded(0.05), std::sqrt(7.814728), 1e-6);
  EXPECT_NEAR(normal_length_exceeded(0.001), std::sqrt(16.266236), 1e-6);
}

TEST(Statistics, RobustDeviationIsConsistentAndIgnoresBlunders) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 0.3);
  std::vector<double> clean(20000);
  for (double& x : clean) x = normal(random);
  EXPECT_NEAR(robust_deviation(clean), 0.3, 0.006);
  for (size_t i = 0; i < clean.size(); i += 20) clean[i] += 50;
  EXPECT_NEAR(robust_deviation(clean), 0.3, 0.02);
}

// 3000 campaigns of 60 poses, read twice in three axes. Without the efficiency 93 % would hold.
TEST(Statistics, IntervalOfRobustDeviationHolds) {
  constexpr int kPairs = 180, kDraws = 3000;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, 1);
  int inside = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> deviations;
    for (int pair = 0; pair < kPairs; ++pair) {
      const double half = (normal(random) - normal(random)) / std::sqrt(2.0);
      deviations.insert(deviations.end(), {half, -half});
    }
    const auto [low, high] =
        deviation_ci95(robust_deviation(deviations), kEfficiencyOfRobustDeviation * kPairs);
    inside += low < 1 && 1 < high;
  }
  EXPECT_NEAR(inside, 0.95 * kDraws, 0.012 * kDraws);  // three standard deviations
}

}  // namespace
}  // namespace armtrue::summary_test
