// Restricted likelihood of a mixed model against dense matrices of all readings.

#include "statistics/variance_components.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include "linear_algebra/decompositions.h"

namespace armtrue::variance_components_test {
namespace {

constexpr Eigen::Index kRows = 120;

struct Problem {
  Eigen::MatrixXd x, z;
  Eigen::VectorXd r;
};

Problem simulated(const Eigen::Vector2d& tau, double noise, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto random = [&](Eigen::Index rows, Eigen::Index cols) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(generator); }));
  };
  Problem problem{random(kRows, 4), random(kRows, 40), {}};
  Eigen::VectorXd u = random(40, 1);
  u.head(20) *= tau[0];
  u.tail(20) *= tau[1];
  problem.r = problem.x * random(4, 1) + problem.z * u + noise * random(kRows, 1);
  return problem;
}

MixedModelSums sums_of(const Problem& problem) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(problem.x);
  const Eigen::MatrixXd q = first_columns(qr.householderQ(), problem.x.cols());
  const Eigen::MatrixXd z = problem.z - q * (q.transpose() * problem.z);
  const Eigen::VectorXd r = problem.r - q * (q.transpose() * problem.r);
  return {z.transpose() * z, z.transpose() * r, r.squaredNorm(),
          static_cast<double>(kRows - problem.x.cols())};
}

Eigen::MatrixXd variance(const Problem& problem, const Eigen::Vector2d& tau, double noise) {
  Eigen::VectorXd squares(40);
  squares.head(20).setConstant(tau[0] * tau[0]);
  squares.tail(20).setConstant(tau[1] * tau[1]);
  return problem.z * squares.asDiagonal() * problem.z.transpose() +
         noise * noise * Eigen::MatrixXd::Identity(kRows, kRows);
}

// ln det V + ln det X^T V^-1 X + r^T P r, P = V^-1 - V^-1 X (X^T V^-1 X)^-1 X^T V^-1.
double minus_twice_restricted(const Problem& problem, const Eigen::Vector2d& tau, double noise) {
  const Eigen::MatrixXd v = variance(problem, tau, noise), inverse = v.inverse();
  const Eigen::MatrixXd xvx = problem.x.transpose() * inverse * problem.x;
  const Eigen::MatrixXd p =
      inverse - inverse * problem.x * xvx.inverse() * problem.x.transpose() * inverse;
  return std::log(v.determinant()) + std::log(xvx.determinant()) +
         problem.r.dot(p * problem.r);
}

constexpr double kNoPrior = 1e3;

TEST(VarianceComponents, MeanIsTheBestLinearUnbiasedPrediction) {
  const Problem problem = simulated({0.5, 0.2}, 1, 1);
  const VarianceComponents found =
      restricted_likelihood(sums_of(problem), {{0, 20, kNoPrior}, {20, 20, kNoPrior}});
  const Eigen::MatrixXd v = variance(problem, found.tau, found.noise), inverse = v.inverse();
  const Eigen::VectorXd b = (problem.x.transpose() * inverse * problem.x)
                                .ldlt()
                                .solve(problem.x.transpose() * inverse * problem.r);
  Eigen::VectorXd expected =
      problem.z.transpose() * (inverse * (problem.r - problem.x * b));
  expected.head(20) *= found.tau[0] * found.tau[0];
  expected.tail(20) *= found.tau[1] * found.tau[1];
  // The variances of the mean are those before the last step, which changes them by 1 % at most.
  EXPECT_LT((found.mean - expected).norm(), 0.03 * expected.norm());
}

TEST(VarianceComponents, NoOtherVariancesAreLikelier) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Problem problem = simulated({0.5, 0.2}, 1, seed);
    const VarianceComponents found =
        restricted_likelihood(sums_of(problem), {{0, 20, kNoPrior}, {20, 20, kNoPrior}});
    const Eigen::Vector2d tau = found.tau;
    const double least = minus_twice_restricted(problem, tau, found.noise);
    for (double factor : {0.8, 1.25}) {
      EXPECT_GT(minus_twice_restricted(problem, {factor * tau[0], tau[1]}, found.noise), least - 0.01);
      EXPECT_GT(minus_twice_restricted(problem, {tau[0], factor * tau[1]}, found.noise), least - 0.01);
      EXPECT_GT(minus_twice_restricted(problem, tau, factor * found.noise), least - 0.01);
    }
    const double alone = std::sqrt(sums_of(problem).rr / sums_of(problem).freedom);
    EXPECT_NEAR(found.gain, minus_twice_restricted(problem, {0, 0}, alone) - least, 0.05);
  }
}

TEST(VarianceComponents, FindsThemInTheMean) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double noise = 0;
  constexpr int kDraws = 200;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    const VarianceComponents found = restricted_likelihood(
        sums_of(simulated({0.5, 0.2}, 1, seed)), {{0, 20, kNoPrior}, {20, 20, kNoPrior}});
    squares += found.tau.head<2>().cwiseAbs2() / kDraws;
    noise += found.noise * found.noise / kDraws;
  }
  EXPECT_NEAR(squares[0], 0.25, 0.025);
  EXPECT_NEAR(squares[1], 0.04, 0.008);
  EXPECT_NEAR(noise, 1, 0.04);
}

TEST(VarianceComponents, APriorKeepsWhatReadingsDoNotTell) {
  Problem problem = simulated({0.5, 0.2}, 1, 3);
  problem.z.rightCols(20) *= 1e-6;
  const VarianceComponents found =
      restricted_likelihood(sums_of(problem), {{0, 20, 1.1}, {20, 20, 1.1}});
  EXPECT_NEAR(found.tau[1], 1, 0.02);
  // The gain is that of the readings: what the priors say of tau is none of it.
  const double alone = std::sqrt(sums_of(problem).rr / sums_of(problem).freedom);
  EXPECT_NEAR(found.gain,
              minus_twice_restricted(problem, {0, 0}, alone) -
                  minus_twice_restricted(problem, found.tau, found.noise),
              0.05);
}

}  // namespace
}  // namespace armtrue::variance_components_test
