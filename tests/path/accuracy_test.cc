#include "armtrue/path/accuracy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace armtrue::accuracy_test {
namespace {

// Along x at 1 m/s, a sample every 10 mm.
Path line(Eigen::Index samples = 11) {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(samples, 0, 0.01 * static_cast<double>(samples - 1));
  path.position = Eigen::Matrix3Xd::Zero(3, samples);
  path.position.row(0) = path.time.transpose();
  return path;
}

Path moved(Path path, double lag, double y, double z) {
  path.position.row(0).array() -= lag;
  path.position.row(1).array() += y;
  path.position.row(2).array() += z;
  return path;
}

TEST(PlaneCrossings, ALagAlongThePathIsNoDeviation) {
  const PlaneCrossings crossings = cross_normal_planes(line(), moved(line(), 0.004, 3e-4, -4e-4));
  ASSERT_EQ(crossings.sample.size(), 10U);  // the last plane is not reached
  for (const auto& deviation : crossings.deviation.colwise())
    EXPECT_NEAR((deviation - Eigen::Vector3d(0, 3e-4, -4e-4)).norm(), 0, 1e-15);
}

TEST(PlaneCrossings, DeviationsOfACircleAreRadial) {
  Path circle;
  constexpr Eigen::Index n = 1001;
  circle.time = Eigen::VectorXd::LinSpaced(n, 0, 10);
  circle.position = Eigen::Matrix3Xd::Zero(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / (n - 1);
    circle.position.col(i) << 0.2 * std::cos(angle), 0.2 * std::sin(angle), 0;
  }
  Path measured = circle;
  measured.position *= 1.005;  // a millimetre outside
  const PlaneCrossings crossings = cross_normal_planes(circle, measured);
  EXPECT_GE(crossings.sample.size(), static_cast<size_t>(n) - 4);
  for (size_t k = 1; k + 1 < crossings.sample.size(); ++k)
    EXPECT_NEAR(crossings.deviation.col(static_cast<Eigen::Index>(k)).norm(), 1e-3, 1e-7);
}

TEST(PlaneCrossings, TheReturnLegIsNotMistakenForTheOutward) {
  Path command;  // out along x in 2 s, back in 2 s
  command.time = Eigen::VectorXd::LinSpaced(401, 0, 4);
  command.position = Eigen::Matrix3Xd::Zero(3, 401);
  for (Eigen::Index i = 0; i < 401; ++i)
    command.position(0, i) = 0.1 * (i <= 200 ? command.time[i] : 4 - command.time[i]);
  Path measured = command;
  for (Eigen::Index i = 0; i < 401; ++i) measured.position(1, i) = i <= 200 ? 1e-3 : -2e-3;
  const PlaneCrossings crossings = cross_normal_planes(command, measured);
  for (size_t k = 0; k < crossings.sample.size(); ++k) {
    const Eigen::Index i = crossings.sample[k];
    if (i > 190 && i < 210) continue;
    EXPECT_EQ(crossings.deviation(1, static_cast<Eigen::Index>(k)), i < 200 ? 1e-3 : -2e-3) << i;
  }
}

// 200 mm along x in 4 s, then 100 mm along y; slow at both ends of a leg, at rest between them.
Path corner() {
  Path path;
  path.time = Eigen::VectorXd::LinSpaced(501, 0, 10);
  path.position = Eigen::Matrix3Xd::Zero(3, 501);
  const auto way = [](double since) {
    return 0.5 - 0.5 * std::cos(M_PI * std::clamp(since, 0., 1.));
  };
  for (Eigen::Index i = 0; i < 501; ++i) {
    path.position(0, i) = 0.2 * way((path.time[i] - 1) / 4);
    path.position(1, i) = 0.1 * way((path.time[i] - 5) / 4);
  }
  return path;
}

// Passes that stand back from the corner miss the last planes of the leg before it. The next leg
// meets these planes a millimetre or more from the corner, which is no deviation.
TEST(PlaneCrossings, ThePlanesBesideACornerDoNotMeetTheNextLeg) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.03e-3);
  std::vector<PlaneCrossings> passes;
  for (int k = 0; k < 3; ++k) {
    Path pass = moved(corner(), 0.3e-3, 0.2e-3, 0);
    for (double& part : pass.position.reshaped()) part += normal(random);
    passes.push_back(cross_normal_planes(corner(), pass));
  }
  const PathAccuracy accuracy = path_accuracy(passes);
  EXPECT_LT(accuracy.at, std::hypot(0.3e-3, 0.2e-3) + 0.05e-3);
  EXPECT_GT(accuracy.at, 0.3e-3);  // of the leg along y
  EXPECT_LT(*accuracy.rt, 0.2e-3);
  EXPECT_GT(accuracy.planes, 380);
}

TEST(PlaneCrossings, StandstillHasNoPlaneAndAMissingStretchIsMissed) {
  Path command = line();
  command.position.col(5) = command.position.col(4);
  EXPECT_EQ(cross_normal_planes(command, line()).sample.size(), 10U);
  Path far = line();
  far.time.array() += 3;  // not registered
  EXPECT_EQ(cross_normal_planes(line(), far).sample.size(), 0U);
  EXPECT_THROW(cross_normal_planes(line(1), line()), std::invalid_argument);
}

// Four passes at the corners of a square of 0.2 mm about (0, 0.3, 0.4) mm; in one plane a fifth of
// that.
TEST(PathAccuracy, EqualsTheHandComputedCase) {
  std::vector<PlaneCrossings> passes;
  for (const auto& [y, z] : {std::pair{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    PlaneCrossings pass =
        cross_normal_planes(line(), moved(line(), 0, 3e-4 + y * 1e-4, 4e-4 + z * 1e-4));
    pass.deviation.col(3).setZero();
    passes.push_back(pass);
  }
  const PathAccuracy accuracy = path_accuracy(passes);
  EXPECT_NEAR(accuracy.at, 5e-4, 1e-15);
  ASSERT_TRUE(accuracy.rt);
  EXPECT_NEAR(*accuracy.rt, std::sqrt(2.0) * 1e-4, 1e-12);  // all radii equal: S = 0
  EXPECT_EQ(accuracy.planes, 11);
}

// Radii 2, 1, 1 about a barycentre: mean 4/3, S^2 = ((2/3)^2 + 2 (1/3)^2) / 2 = 1/3.
TEST(PathAccuracy, RepeatabilityIsMeanRadiusPlusThreeDeviations) {
  std::vector<PlaneCrossings> passes;
  for (const double y : {2e-4, -1e-4, -1e-4})
    passes.push_back(cross_normal_planes(line(), moved(line(), 0, y, 0)));
  passes[0].deviation(1, 6) = 5e-4;  // radii 4, 2, 2 there, barycentre 1: mean 8/3, S = 2/sqrt(3)
  passes[1].deviation(1, 6) = passes[2].deviation(1, 6) = -1e-4;
  const PathAccuracy accuracy = path_accuracy(passes);
  EXPECT_NEAR(*accuracy.rt, (8.0 / 3 + 3 * 2 / std::sqrt(3.0)) * 1e-4, 1e-15);
  EXPECT_NEAR(accuracy.at, 1e-4, 1e-15);
}

TEST(PathAccuracy, OnePassHasNoRepeatabilityAndMissedPlanesTakeNoPart) {
  PlaneCrossings whole = cross_normal_planes(line(), moved(line(), 0, 1e-4, 0));
  EXPECT_FALSE(path_accuracy({whole}).rt);
  EXPECT_NEAR(path_accuracy({whole}).at, 1e-4, 1e-15);
  const PlaneCrossings late = cross_normal_planes(line(), moved(line(), 0.025, 1e-4, 0));
  const PathAccuracy both = path_accuracy({whole, late});
  EXPECT_EQ(both.planes, 8);
  EXPECT_THROW(path_accuracy({}), std::invalid_argument);
  EXPECT_THROW(path_accuracy({whole, PlaneCrossings{}}), std::invalid_argument);
}

// Passes with independent normal noise of one deviation s in the plane: the expectations of the
// mean radius and of S follow from the law of Rayleigh, with (n - 1) / n of the variance left about
// the barycentre.
TEST(PathAccuracy, AgreesWithTheLawOfNoise) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0, 1e-4);
  constexpr int kPasses = 400;
  std::vector<PlaneCrossings> passes;
  for (int j = 0; j < kPasses; ++j) {
    Path pass = line(3);
    for (Eigen::Index i = 0; i < 3; ++i) {
      pass.position(1, i) += 2e-4 + normal(random);
      pass.position(2, i) += normal(random);
    }
    passes.push_back(cross_normal_planes(line(3), pass));
  }
  const PathAccuracy accuracy = path_accuracy(passes);
  EXPECT_NEAR(accuracy.at, 2e-4, 2e-5);
  const double expected = (std::sqrt(M_PI / 2) + 3 * std::sqrt(2 - M_PI / 2)) * 1e-4;
  EXPECT_NEAR(*accuracy.rt, expected, 0.07 * expected);
}

TEST(PathErrors, PerAxisAndWhole) {
  Eigen::Matrix3Xd deviation(3, 2);
  deviation << 3, -1, 4, 0, 0, 0;
  const PathErrors errors = path_errors(deviation);
  EXPECT_EQ(errors.axis[0].mean, 2);
  EXPECT_EQ(errors.axis[0].max, 3);
  EXPECT_EQ(errors.axis[1].mean, 2);
  EXPECT_EQ(errors.axis[2].rms, 0);
  EXPECT_EQ(errors.whole.mean, 3);
  EXPECT_DOUBLE_EQ(errors.whole.rms, std::sqrt(13.0));
}

TEST(PathErrors, ReductionIsThatOfTheMean) {
  Eigen::Matrix3Xd before(3, 2), after(3, 2);
  before << 3, -3, 4, 4, 0, 0;
  after << 1.5, -1.5, 0, 0, 0, 1;
  const Reduction gone = reduction(path_errors(before), path_errors(after));
  EXPECT_DOUBLE_EQ(*gone.axis[0], 0.5);
  EXPECT_DOUBLE_EQ(*gone.axis[1], 1);
  EXPECT_FALSE(gone.axis[2]);  // nothing was there to reduce
  EXPECT_DOUBLE_EQ(*gone.whole, 1 - (1.5 + std::sqrt(3.25)) / 10);
}

}  // namespace
}  // namespace armtrue::accuracy_test
