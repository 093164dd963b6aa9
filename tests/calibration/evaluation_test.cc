#include "armtrue/calibration/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armtrue {
namespace {

TEST(Evaluation, MeanErrorOfNoiseIsThatOfThreeNormalAxes) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal(0, 0.095);
  double sum = 0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i)
    sum += std::hypot(normal(random), normal(random), normal(random));
  EXPECT_NEAR(mean_error_of_noise(0.095), sum / kDraws, 0.0005);
}

}  // namespace
}  // namespace armtrue
