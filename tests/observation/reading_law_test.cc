#include "armtrue/observation/reading_law.h"

#include <gtest/gtest.h>

#include <cmath>
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
Readings drawn(int rows, int dof, const ReadingSigma& sigma, bool orientation) {
  Random random(5);
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

}  // namespace
}  // namespace armtrue::reading_law_test
