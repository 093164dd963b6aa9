#include "path/mirror/mean_deviation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/kinematics/pose.h"
#include "armtrue/path/registration/clock.h"

namespace armtrue::mean_deviation_test {
namespace {

using Eigen::Vector3d;

constexpr Eigen::Index kSamples = 101;
const Vector3d kForce(30, -20, 10), kOff(0, 2e-4, -1e-4);  // in the axes of the program

// Along x at 1 m/s for a second.
Path line() {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(kSamples, 0, 1);
  path.position = Eigen::Matrix3Xd::Zero(3, kSamples);
  path.position.row(0) = path.time.transpose();
  return path;
}

// The frame of an instrument that stands aside, turned.
const Pose kFrame{rotation_exp({0.3, -0.2, 1.1}), {1, -2, 0.5}};

// Beside the line under a steady force, as the instrument has both.
Path record(const Vector3d& off) {
  Path path = line();
  for (Eigen::Index i = 0; i < kSamples; ++i)
    path.position.col(i) = inverse(kFrame) * Vector3d(path.position.col(i) + off);
  path.force = (kFrame.rotation.transpose() * kForce).replicate(1, kSamples);
  return path;
}

TEST(Registered, ARecordHasItsForceInTheFrameOfTheProgram) {
  ClockFit clock;
  clock.program_from_instrument = kFrame;
  const Path own = registered(record(kOff), clock);
  EXPECT_LT((own.force.colwise() - kForce).norm(), 1e-12);
  EXPECT_LT((own.position - (line().position.colwise() + kOff)).norm(), 1e-12);
}

// Two passes with clocks that err independently: the mean errs by half of their variance.
TEST(MeanDeviation, HasForceAndClockOfTheProgram) {
  std::vector<Pass> passes(2);
  for (Pass& pass : passes) {
    pass.clock.program_from_instrument = kFrame;
    pass.clock.middle = 0.5;
    pass.clock.covariance << 4e-8, 0, 0, 1e-10;
  }
  const PathDeviation mean = mean_deviation(line(), {record(kOff), record(3 * kOff)}, passes);
  EXPECT_LT((mean.force.colwise() - kForce).norm(), 1e-9);
  EXPECT_LT((mean.whole.colwise() - 2 * kOff).norm(), 1e-9);
  EXPECT_NEAR(mean.clock_covariance(0, 0), 2e-8, 1e-14);
  EXPECT_NEAR(mean.clock_covariance(1, 1), 0.5e-10, 1e-16);
}

}  // namespace
}  // namespace armtrue::mean_deviation_test
