#include "armtrue/statistics/autocorrelated_regression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "armtrue/statistics/distributions.h"
#include "support/thinned.h"

namespace armtrue::autocorrelated_regression_test {
namespace {

using Random = std::mt19937_64;

Eigen::MatrixXd no_noise(Eigen::Index p) { return Eigen::MatrixXd::Zero(p, p); }
Eigen::MatrixXd none_shared(Eigen::Index n) { return Eigen::MatrixXd(n, 0); }

// x[i] = rho x[i-1] + e, `times` over, of about unit variance; twice is smooth like what a low pass
// leaves.
Eigen::VectorXd slow_noise(Eigen::Index n, double rho, int times, Random& random) {
  std::normal_distribution<double> normal;
  constexpr Eigen::Index kWarmUp = 500;
  Eigen::VectorXd x(n + kWarmUp);
  for (double& value : x) value = normal(random);
  for (int time = 0; time < times; ++time)
    for (Eigen::Index i = 1; i < x.size(); ++i)
      x[i] = rho * x[i - 1] + std::sqrt(1 - rho * rho) * x[i];
  return x.tail(n);
}

// Force of a pass: air, in the material from a fifth on, air.
Eigen::VectorXd pulse(Eigen::Index n, double ripple) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = n / 5; i < n * 17 / 20; ++i)
    x[i] = 40 + ripple * std::sin(8 * M_PI * static_cast<double>(i) / static_cast<double>(n));
  return x;
}

Eigen::MatrixXd pulse_constant_step(Eigen::Index n) {
  Eigen::MatrixXd columns(n, 3);
  columns << pulse(n, 10), Eigen::VectorXd::Ones(n), Eigen::VectorXd::Constant(n, 0.5);
  columns.col(2).head(n / 2).setConstant(-0.5);
  return columns;
}

struct Case {
  const char* name;
  Eigen::MatrixXd columns;
  double rho;
  int times;
};

// Beside what the residual shows an error that all samples share, of known deviation: along the
// column itself the residual does not show it. JCGM 100:2008, G.4: the degrees of freedom are those
// of the shown part times (whole variance / shown variance)^2.
TEST(AutocorrelatedRegression, AKnownErrorBesideAddsDegreesOfFreedom) {
  constexpr double kKnown = 0.02;
  Random random(4);
  const Eigen::MatrixXd column = pulse(700, 10);
  const Eigen::VectorXd response = 0.1 * column + slow_noise(700, 0.8, 1, random);
  const auto fit = [&](const Eigen::MatrixXd& shared) {
    return regress_autocorrelated(column, response, no_noise(1), shared).coefficients.front();
  };
  const Estimate shown = fit(none_shared(700)), both = fit(kKnown * column);
  const auto half_width = [](const Estimate& one) { return (one.ci95[1] - one.ci95[0]) / 2; };
  EXPECT_NEAR(both.std, std::hypot(shown.std, kKnown), 1e-12);
  double freedom = 2;  // a whole number from 2 to 24
  while (freedom < 24 && student_t_quantile(0.975, freedom + 0.5) * shown.std > half_width(shown))
    ++freedom;
  EXPECT_NEAR(half_width(shown), student_t_quantile(0.975, freedom) * shown.std, 1e-12);
  const double times = std::pow(both.std / shown.std, 4);
  EXPECT_GT(times, 1.2);
  EXPECT_NEAR(half_width(both), student_t_quantile(0.975, freedom * times) * both.std, 1e-9);
}

TEST(AutocorrelatedRegression, IntervalsCoverTheTruthWhenTheResidualWanders) {
  const int part = thinned(4), campaigns = 2000 / part;
  const double bound = 0.02 * std::sqrt(part);  // four standard deviations of a share
  constexpr Eigen::Index n = 700;
  const Case cases[] = {
      {"constant, white", Eigen::MatrixXd::Ones(n, 1), 0, 1},
      {"constant, rho 0.8", Eigen::MatrixXd::Ones(n, 1), 0.8, 1},
      {"constant, rho 0.95", Eigen::MatrixXd::Ones(n, 1), 0.95, 1},
      {"force, white", pulse(n, 0), 0, 1},
      {"force, rho 0.8", pulse(n, 0), 0.8, 1},
      {"force, rho 0.95", pulse(n, 0), 0.95, 1},
      {"force, smooth", pulse(n, 15), 0.8, 2},
      {"force, smooth, oversampled", pulse(4 * n, 15), 0.95, 2},
      {"force and step, white", pulse_constant_step(n), 0, 1},
      {"force and step, rho 0.8", pulse_constant_step(n), 0.8, 1},
      {"force and step, smooth", pulse_constant_step(n), 0.8, 2},
      {"force and step, rho 0.95", pulse_constant_step(2 * n), 0.95, 1},
  };
  Random random(11);
  for (const Case& c : cases) {
    const Eigen::VectorXd truth = Eigen::VectorXd::LinSpaced(c.columns.cols(), 0.02, -0.3);
    std::vector<int> covered(static_cast<size_t>(truth.size()), 0);
    for (int campaign = 0; campaign < campaigns; ++campaign) {
      const Eigen::VectorXd response =
          c.columns * truth + 0.1 * slow_noise(c.columns.rows(), c.rho, c.times, random);
      const Regression fit = regress_autocorrelated(c.columns, response, no_noise(truth.size()),
                                                    none_shared(c.columns.rows()));
      for (size_t k = 0; k < covered.size(); ++k) {
        const double value = truth[static_cast<Eigen::Index>(k)];
        const auto [low, high] = fit.coefficients[k].ci95;
        covered[k] += low <= value && value <= high;
      }
    }
    std::printf("%-28s", c.name);
    for (const int count : covered) {
      const double share = static_cast<double>(count) / campaigns;
      std::printf(" %.3f", share);
      EXPECT_NEAR(share, 0.95, bound) << c.name;
    }
    std::printf("\n");
  }
}

// A clock that is off moves all samples of a pass along the path: at a corner that is a step, on a
// curve a wave.
TEST(AutocorrelatedRegression, IntervalsKnowOfErrorsThatAllSamplesShare) {
  constexpr int kCampaigns = 1000;
  constexpr Eigen::Index n = 700;
  const Eigen::MatrixXd columns = pulse_constant_step(n);
  const Eigen::Vector3d truth(0.02, -0.1, -0.3);
  Eigen::MatrixXd shared(n, 2);
  shared << 0.1 * columns.col(2), 0.05 * Eigen::VectorXd::LinSpaced(n, 0, 3).array().cos().matrix();
  Random random(12);
  std::normal_distribution<double> normal;
  int aware = 0, unaware = 0;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    const Eigen::Vector2d errors(normal(random), normal(random));
    const Eigen::VectorXd response =
        columns * truth + shared * errors + 0.1 * slow_noise(n, 0.8, 2, random);
    const auto covered = [&](const Regression& fit) {
      int count = 0;
      for (size_t k = 0; k < 3; ++k) {
        const auto [low, high] = fit.coefficients[k].ci95;
        count += low <= truth[static_cast<Eigen::Index>(k)] &&
                 truth[static_cast<Eigen::Index>(k)] <= high;
      }
      return count;
    };
    aware += covered(regress_autocorrelated(columns, response, no_noise(3), shared));
    unaware += covered(regress_autocorrelated(columns, response, no_noise(3), none_shared(n)));
  }
  std::printf("covered: %.3f, without the shared errors %.3f\n", aware / (3.0 * kCampaigns),
              unaware / (3.0 * kCampaigns));
  EXPECT_GE(aware, 0.93 * 3 * kCampaigns);
  EXPECT_LE(aware, 0.97 * 3 * kCampaigns);
  EXPECT_LT(unaware, 0.9 * 3 * kCampaigns);
}

TEST(AutocorrelatedRegression, NoiseInAColumnNoLongerShrinksItsCoefficient) {
  constexpr Eigen::Index n = 20000;
  Random random(3);
  std::normal_distribution<double> normal;
  Eigen::VectorXd seen = pulse(n, 15);
  const Eigen::VectorXd response = 0.02 * seen;
  for (double& x : seen) x += 15 * normal(random);
  const double raw =
      regress_autocorrelated(seen, response, no_noise(1), none_shared(n)).coefficients[0].value;
  EXPECT_LT(raw, 0.0175);
  const Estimate k =
      regress_autocorrelated(seen, response, Eigen::MatrixXd::Constant(1, 1, 225), none_shared(n))
          .coefficients[0];
  EXPECT_NEAR(k.value, 0.02, 2e-4);
  EXPECT_LE(k.ci95[0], 0.02);
  EXPECT_GE(k.ci95[1], 0.02);
}

TEST(AutocorrelatedRegression, RefusesWhatCannotBeSolved) {
  const Eigen::MatrixXd twice = Eigen::MatrixXd::Ones(10, 2);
  EXPECT_THROW(
      regress_autocorrelated(twice, Eigen::VectorXd::Ones(10), no_noise(2), none_shared(10)),
      std::invalid_argument);
  EXPECT_THROW(
      regress_autocorrelated(twice, Eigen::VectorXd::Ones(9), no_noise(2), none_shared(10)),
      std::invalid_argument);
  EXPECT_THROW(regress_autocorrelated(Eigen::MatrixXd::Ones(10, 1), Eigen::VectorXd::Ones(10),
                                      no_noise(1), Eigen::MatrixXd::Ones(9, 1)),
               std::invalid_argument);
  EXPECT_THROW(regress_autocorrelated(Eigen::MatrixXd::Identity(2, 2), Eigen::VectorXd::Ones(2),
                                      no_noise(2), none_shared(2)),
               std::invalid_argument);
  // A column that is all noise.
  EXPECT_THROW(regress_autocorrelated(Eigen::MatrixXd::Ones(10, 1), Eigen::VectorXd::Ones(10),
                                      Eigen::MatrixXd::Ones(1, 1), none_shared(10)),
               std::invalid_argument);
}

}  // namespace
}  // namespace armtrue::autocorrelated_regression_test
