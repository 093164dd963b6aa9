#include "armtrue/path/low_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "path/smoothing_spline.h"

namespace armtrue::low_pass_test {
namespace {

constexpr double kRate = 31.25, kCutoff = 1.5625;

Eigen::MatrixXd impulse(Eigen::Index samples) {
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(1, samples);
  values(samples / 2) = 1;
  return values;
}

// Amplitude of a long sine after the filter, away from the ends.
template <typename Filter>
double gain(const Filter& filter, double frequency) {
  constexpr Eigen::Index kSamples = 2000;
  Eigen::MatrixXd sine(1, kSamples);
  for (Eigen::Index i = 0; i < kSamples; ++i)
    sine(i) = std::sin(2 * std::numbers::pi * frequency * static_cast<double>(i) / kRate);
  return filter(sine).middleCols(500, 1000).norm() / sine.middleCols(500, 1000).norm();
}

// scipy.signal: butter(4, w, output="sos") with the widened cut-off, sosfilt there and back.
TEST(LowPass, HasTheImpulseResponseOfScipy) {
  const Eigen::MatrixXd response = LowPass(4, kCutoff, kRate)(impulse(401));
  const double expected[] = {0.11406855836259333, 0.11124784314955767, 0.10310349320032193,
                             0.09052909055432255, 0.07483475306015558, 0.05753616519586107};
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(response(200 + k), expected[k], 1e-12);
    EXPECT_NEAR(response(200 - k), expected[k], 1e-9);  // no phase
  }
}

TEST(LowPass, LosesThreeDecibelsAtTheCutoffInBothPassesTogether) {
  for (const int order : {1, 2, 3, 4, 7})
    EXPECT_NEAR(gain(LowPass(order, kCutoff, kRate), kCutoff), std::numbers::sqrt2 / 2, 2e-3)
        << order;
}

TEST(LowPass, LetsItsShareOfWhiteNoisePass) {
  const LowPass filter(4, kCutoff, kRate);
  EXPECT_NEAR(filter.noise_share(), filter(impulse(2001)).squaredNorm(), 1e-6);
}

TEST(LowPass, KeepsStraightLinesUpToTheirEnds) {
  const Eigen::MatrixXd line = Eigen::RowVectorXd::LinSpaced(400, -3, 5);
  EXPECT_LT((LowPass(4, kCutoff, kRate)(line) - line).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(LowPass, RefusesACutoffThatTheSamplesDoNotShow) {
  EXPECT_THROW(LowPass(4, 14, kRate), std::invalid_argument);
  EXPECT_THROW(LowPass(4, 0, kRate), std::invalid_argument);
  EXPECT_THROW(LowPass(0, 1, kRate), std::invalid_argument);
}

TEST(SmoothingSpline, LosesThreeDecibelsAtTheCutoff) {
  const auto spline = [](const Eigen::MatrixXd& samples) {
    return smoothing_spline(samples, kCutoff, kRate);
  };
  EXPECT_NEAR(gain(spline, kCutoff), std::numbers::sqrt2 / 2, 5e-3);
  EXPECT_NEAR(smoothing_spline_noise_share(kCutoff, kRate),
              smoothing_spline(impulse(2001), kCutoff, kRate).squaredNorm(), 1e-6);
}

TEST(SmoothingSpline, KeepsStraightLinesAndShortRecords) {
  const Eigen::MatrixXd line = Eigen::RowVectorXd::LinSpaced(40, -3, 5);
  EXPECT_LT((smoothing_spline(line, kCutoff, kRate) - line).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(smoothing_spline(line.leftCols(2), kCutoff, kRate), line.leftCols(2));
}

}  // namespace
}  // namespace armtrue::low_pass_test
