#include "path/mirror/breaks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "armtrue/kinematics/units.h"

namespace armtrue::breaks_test {
namespace {

// The tool moves all the time; one joint swings by `amplitude` about its start, with turning points
// at 1, 3, 5, ... s.
Path swinging(double amplitude, double period) {
  Path path;
  const auto samples = static_cast<Eigen::Index>(8 / period) + 1;
  path.time = Eigen::VectorXd::LinSpaced(samples, 0, period * static_cast<double>(samples - 1));
  path.position = Eigen::Matrix3Xd::Zero(3, samples);
  path.position.row(0) = 0.1 * path.time.transpose();
  path.q = JointMatrix::Zero(6, samples);
  path.q.row(3) = amplitude * (M_PI / 2 * path.time.array()).sin().matrix().transpose();
  return path;
}

std::vector<double> within(const std::vector<double>& times, double begin, double end) {
  std::vector<double> some;
  for (const double time : times)
    if (time > begin && time < end) some.push_back(time);
  return some;
}

// A slow joint moves by less between two samples than a reversal has to show.
TEST(Breaks, AJointReversesHoweverSlowly) {
  for (const double amplitude : {20 * kDegree, 0.1 * kDegree})
    for (const double period : {0.1, 0.004}) {
      const std::vector<double> times =
          within(program_breaks(swinging(amplitude, period)), 0.5, 7.5);
      ASSERT_EQ(times.size(), 4U) << amplitude << " " << period;
      for (size_t k = 0; k < times.size(); ++k)
        EXPECT_NEAR(times[k], 1 + 2 * static_cast<double>(k), period + 1e-9);
    }
  EXPECT_TRUE(within(program_breaks(swinging(0.004 * kDegree, 0.004)), 0.5, 7.5).empty());
}

}  // namespace
}  // namespace armtrue::breaks_test
