// What is expected of a trend and of a fitted frame, by hand.

#include <gtest/gtest.h>

#include <cmath>

#include "path/mirror/frame_error.h"
#include "path/mirror/trend.h"

namespace armtrue::expected_error_test {
namespace {

using Eigen::Vector3d;

constexpr Eigen::Index kSamples = 100;

// Two pieces, 0.3 mm aside of a trend of zero, with noise of 0.1 mm in each of two components.
PathDeviation aside(double off) {
  PathDeviation deviation;
  deviation.time = Eigen::VectorXd::LinSpaced(kSamples, 0, 0.99);
  deviation.period = 0.01;
  deviation.noise = 1e-4;
  deviation.breaks = {40};
  deviation.normal = Vector3d(0, off, 0).replicate(1, kSamples);
  deviation.trend = Eigen::Matrix3Xd::Zero(3, kSamples);
  return deviation;
}

// Stein: left^2 - noise^2 + 2 noise^2 kept, and no less than what is kept of the noise. A filter
// keeps its share and a constant of each piece; polygons two numbers of a vertex, three within a
// piece.
TEST(Trend, ExpectsWhatItMissesAndWhatItKeepsOfTheNoise) {
  constexpr double kNoise = 2e-8, kLeft = 9e-8, kShare = 0.1;
  const double of_filter = kShare + 2.0 / kSamples, of_polygon = (7 + 3 / 2.0) / kSamples;
  EXPECT_NEAR(expected_square(aside(3e-4), CorrectionPoints::spline, 7, kShare),
              kLeft - kNoise + 2 * kNoise * of_filter, 1e-14);
  EXPECT_NEAR(expected_square(aside(3e-4), CorrectionPoints::turning, 7, kShare),
              kLeft - kNoise + 2 * kNoise * of_polygon, 1e-14);
  EXPECT_NEAR(expected_square(aside(0), CorrectionPoints::spline, 7, kShare), kNoise * of_filter,
              1e-14);
}

// Along x; the frame errs by s along y, and along x, which no deviation across the path shows. With
// the deviation d along y, the mean of (d + e)^2 - d^2 is s^2, of variance 4 d^2 s^2 + 2 s^4.
TEST(Frame, ErrsAcrossThePathAlone) {
  constexpr double kOff = 3e-4, kFrame = 1e-4;
  Path line;
  line.time = Eigen::VectorXd::LinSpaced(kSamples, 0, 0.99);
  line.position = Eigen::Matrix3Xd::Zero(3, kSamples);
  line.position.row(0) = line.time.transpose();
  ClockFit clock;
  clock.frame_covariance.diagonal() << 4e-8, kFrame * kFrame, 0, 0, 0, 0;
  const FrameError error = frame_error(line, aside(kOff), clock);
  EXPECT_NEAR(error.mean_square, kFrame * kFrame, 1e-15);
  EXPECT_NEAR(error.form_deviation, std::sqrt(4 * kOff * kOff + 2 * kFrame * kFrame) * kFrame,
              1e-14);
}

}  // namespace
}  // namespace armtrue::expected_error_test
