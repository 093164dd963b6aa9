#include "statistics/white_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/statistics/random.h"

namespace armtrue::white_noise_test {
namespace {

// Across a path along x two components have noise; the bend beside it is slow.
TEST(WhiteNoise, IsTheDeviationOfOneComponentAcrossAPath) {
  constexpr double kNoise = 3e-5;
  constexpr Eigen::Index kSamples = 20000;
  Random random(3);
  Eigen::Matrix3Xd samples = Eigen::Matrix3Xd::Zero(3, kSamples);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double slow = 1e-3 * std::sin(0.01 * static_cast<double>(i));
    samples(1, i) = slow + kNoise * random.normal();
    samples(2, i) = -2 * slow + kNoise * random.normal();
  }
  EXPECT_NEAR(white_noise(samples), kNoise, 0.03 * kNoise);
}

TEST(WhiteNoise, OfFewerThanFourSamplesIsNotKnown) {
  EXPECT_EQ(white_noise(Eigen::Matrix3Xd::Random(3, 3)), 0);
}

}  // namespace
}  // namespace armtrue::white_noise_test
