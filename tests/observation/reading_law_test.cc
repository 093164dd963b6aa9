#include "armtrue/observation/reading_law.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/statistics/random.h"

namespace armtrue::reading_law_test {
namespace {

struct Readings {
  Campaign campaign;
  std::vector<Eigen::Vector2d> norms;
};

// Poses that are read once, points or full poses; residuals by Student's t.
Readings drawn(int rows, int dof, const ReadingSigma& sigma, bool orientation,
               std::uint64_t seed = 5) {
  Random random(seed);
  Readings readings;
  for (int row = 0; row < rows; ++row) {
    readings.campaign.pose.push_back(row);
    readings.campaign.pose_ids.push_back(std::to_string(row));
    readings.campaign.q.emplace_back();
    readings.campaign.position.push_back(Eigen::Vector3d::Zero());
    if (orientation) readings.campaign.orientation.push_back(Eigen::Quaterniond::Identity());
    double chi_square = 0;
    for (int k = 0; k < dof; ++k) chi_square += std::pow(random.normal(), 2);
    Eigen::Vector2d norms = Eigen::Vector2d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      norms[0] += std::pow(sigma.position * random.normal(), 2);
      if (orientation) norms[1] += std::pow(sigma.orientation * random.normal(), 2);
    }
    readings.norms.push_back(norms * (dof / chi_square));
  }
  return readings;
}

// What EM by the number of rows, written out, ends at: sigma^2 = correction / (3 n) sum w |r|^2.
TEST(ReadingLaw, SigmaIsTheFixedPointOfExpectationMaximisation) {
  const ReadingSigma drawn_with{1e-4, 3e-4}, start{3e-4, 1e-4};
  const Eigen::Array2d correction(1.2, 1.1);
  for (const bool orientation : {false, true}) {
    const Readings readings = drawn(2000, 3, drawn_with, orientation);
    const auto [sigma, law] =
        describe_residuals(readings.norms, readings.campaign, start, correction, true);
    const double nu = law.degrees_of_freedom, d = orientation ? 6 : 3;
    EXPECT_GE(nu, 2);
    EXPECT_LE(nu, 4);
    Eigen::Array2d own(drawn_with.position, drawn_with.orientation);
    for (int round = 0; round < 1000; ++round) {
      Eigen::Array2d sum = Eigen::Array2d::Zero();
      for (const Eigen::Vector2d& norms : readings.norms) {
        const double s = norms[0] / (own[0] * own[0]) + norms[1] / (own[1] * own[1]);
        sum += (nu + d) / (nu + s) * norms.array();
      }
      own = (correction * sum / (3.0 * static_cast<double>(readings.norms.size()))).sqrt();
      if (!orientation) own[1] = 1;
    }
    EXPECT_NEAR(sigma.position, own[0], 1e-7 * own[0]);
    if (orientation) {
      EXPECT_NEAR(sigma.orientation, own[1], 1e-7 * own[1]);
    }
  }
}

TEST(ReadingLaw, GaussianReadingsStayGaussian) {
  const Readings readings = drawn(2000, 400, {1e-4, 3e-4}, true);
  const auto [sigma, law] =
      describe_residuals(readings.norms, readings.campaign, {1e-4, 3e-4}, {1, 1}, true);
  EXPECT_EQ(law.degrees_of_freedom, 0);
  EXPECT_NEAR(sigma.position, 1e-4, 2e-6);
  EXPECT_NEAR(sigma.orientation, 3e-4, 6e-6);
}

// One more parameter than that of a Gaussian law costs log(rows) / 2: 2 (L_t - L) > ln 50 happens
// by chance to one sample in forty or less.
TEST(ReadingLaw, FewGaussianReadingsSeldomLookLikeStudentsT) {
  int taken = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Readings readings = drawn(50, 400, {1e-4, 3e-4}, false, seed);
    taken += describe_residuals(readings.norms, readings.campaign, {1e-4, 3e-4}, {1, 1}, true)
                 .law.degrees_of_freedom > 0;
  }
  EXPECT_LE(taken, 5);
}

// Read five times each: that a pose is off by chance is no variance of its own.
TEST(ReadingLaw, GaussianReplicatesStayGaussian) {
  Readings readings = drawn(2000, 400, {1e-4, 3e-4}, true);
  for (int& pose : readings.campaign.pose) pose /= 5;
  readings.campaign.pose_ids.resize(400);
  const auto [sigma, law] =
      describe_residuals(readings.norms, readings.campaign, {1e-4, 3e-4}, {1, 1}, true);
  EXPECT_EQ(law.degrees_of_freedom, 0);
}

TEST(ReadingLaw, APoseCountsInFullUpToThreeTimesTheUsualDeviation) {
  std::vector<double> variance(90, 2.0);
  variance.resize(91, 2.0);
  variance.resize(100, 500.0);
  EXPECT_DOUBLE_EQ(bounded_law(4, variance).most_counted, 9 * 2.0);
}

// S / sigma^2 = f + (u - rho u of the other) / (4 (1 - rho^2)), u = ln(sigma / expected), rho 7/8.
TEST(ReadingLaw, SigmaOfFewReadingsLeansOnWhatIsExpectedAndOnTheOtherSigma) {
  const ReadingSigma estimate{3e-4, 2e-3}, expected{1e-4, 1e-4};
  const Eigen::Array2d freedom(2, 0.5);
  const ReadingSigma found = sigma_with_prior(estimate, freedom, expected, true);
  constexpr double kRho = 0.875;
  const std::array u{std::log(found.position / expected.position),
                     std::log(found.orientation / expected.orientation)};
  const std::array ratio{estimate.position / found.position,
                         estimate.orientation / found.orientation};
  for (size_t k = 0; k < 2; ++k) {
    const double f = freedom[static_cast<Eigen::Index>(k)];
    EXPECT_NEAR(f * ratio[k] * ratio[k], f + (u[k] - kRho * u[1 - k]) / (4 * (1 - kRho * kRho)),
                1e-6)
        << k;
  }
  EXPECT_GT(u[0], 0.1);
  EXPECT_GT(u[1], 0.1);
}

// Of lengths and of points, from the medians of their squares.
TEST(ReadingLaw, MedianSigmaIsThatOfAnAxis) {
  Random random(2);
  std::vector<Eigen::Vector2d> lengths, poses;
  for (int row = 0; row < 20000; ++row) {
    const double length = 3e-4 * random.normal();
    lengths.emplace_back(length * length, 0);
    const Eigen::Vector3d place = 3e-4 * random.normal3(), turn = 2e-3 * random.normal3();
    poses.emplace_back(place.squaredNorm(), turn.squaredNorm());
  }
  EXPECT_NEAR(median_sigma(lengths, {1, 0}).position, 3e-4, 0.03 * 3e-4);
  const ReadingSigma of_poses = median_sigma(poses, {3, 3});
  EXPECT_NEAR(of_poses.position, 3e-4, 0.02 * 3e-4);
  EXPECT_NEAR(of_poses.orientation, 2e-3, 0.02 * 2e-3);
}

}  // namespace
}  // namespace armtrue::reading_law_test
