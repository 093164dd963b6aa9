#include "armtrue/statistics/intervals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armtrue::intervals_test {
namespace {

// Feldman and Cousins 1998, table X, 95 %: intervals of the mean for a measured value in standard
// deviations.
TEST(NotNegative, IsThatOfTheTableOfFeldmanAndCousins) {
  const auto unit = [](double) { return 1.0; };
  for (const auto& [measured, low, high] :
       {std::tuple{-3.0, 0.0, 0.42}, {-1.0, 0.0, 1.10}, {0.0, 0.0, 1.96}, {1.0, 0.0, 2.96},
        {2.0, 0.35, 3.96}, {3.0, 1.14, 4.96}}) {
    const auto [from, to] = not_negative_ci95(measured, unit);
    EXPECT_NEAR(from, low, 0.015) << measured;
    EXPECT_NEAR(to, high, 0.015) << measured;
  }
}

TEST(NotNegative, CoversWhateverTheTruth) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto deviation = [](double truth) { return std::sqrt(1 + truth); };
  for (const double truth : {0.0, 0.1, 0.5, 1.0, 3.0, 10.0}) {
    int covered = 0;
    constexpr int kRuns = 2000;
    for (int k = 0; k < kRuns; ++k) {
      const auto [low, high] = not_negative_ci95(truth + deviation(truth) * normal(random), deviation);
      EXPECT_LT(low, high);
      covered += low <= truth && truth <= high;
    }
    EXPECT_NEAR(covered, 0.95 * kRuns, 40) << truth;  // 4 standard deviations
  }
}

// chi^2 of 20 degrees of freedom: 2.5 % below 9.591, 2.5 % above 34.170.
TEST(Deviation, IsThatOfTheTableOfChiSquared) {
  const auto [low, high] = deviation_ci95(2, 20);
  EXPECT_NEAR(low, 2 * std::sqrt(20 / 34.170), 1e-4);
  EXPECT_NEAR(high, 2 * std::sqrt(20 / 9.591), 1e-4);
}

}  // namespace
}  // namespace armtrue::intervals_test
