#include "armtrue/observation/reading_law.h"

#include <math.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "armtrue/statistics/summary.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kMaxRoundsOfSigma = 30;     // under one law
constexpr double kSigmaTolerance = 1e-9;  // relative change that ends them
constexpr int kMaxRoundsOfLaw = 8;  // of variances and sigma in turn; they settle in three or four

// Squared norm of the whitened residual from those of position and orientation [m^2, rad^2].
double whitened(const Eigen::Vector2d& s, const ReadingSigma& sigma, const ReadingSize& size) {
  return s[0] / (sigma.position * sigma.position) +
         (size.orientation > 0 ? s[1] / (sigma.orientation * sigma.orientation) : 0.0);
}

// std::lgamma writes its sign into a variable that all threads share.
double log_gamma(double x) {
  int sign = 0;
  return lgamma_r(x, &sign);
}

// Squared norms of the residuals of all rows [m^2, rad^2], and ReadingLaw::variance. One array for
// each, so that the compiler vectorises.
struct Rows {
  Eigen::ArrayXd position, orientation, variance;
  ReadingSize size;

  Rows(const std::vector<Eigen::Vector2d>& norms, const std::vector<double>& variances,
       const ReadingSize& reading_size)
      : position(std::ssize(norms)),
        orientation(std::ssize(norms)),
        variance(Eigen::ArrayXd::Ones(std::ssize(norms))),
        size(reading_size) {
    for (size_t row = 0; row < norms.size(); ++row) {
      const Eigen::Index k = row;
      position[k] = norms[row][0];
      orientation[k] = size.orientation > 0 ? norms[row][1] : 0.0;
      if (!variances.empty()) variance[k] = variances[row];
    }
  }
};

// Calls take(first, count, s) for blocks of rows, with s as in ReadingLaw.
template <typename Take>
void for_each_whitened(const Rows& rows, const ReadingSigma& sigma, const Take& take) {
  constexpr Eigen::Index kRowsAtOnce = 1024;  // stay in the cache
  const double by_position = 1 / (sigma.position * sigma.position);
  const double by_orientation =
      rows.size.orientation > 0 ? 1 / (sigma.orientation * sigma.orientation) : 0.0;
  Eigen::ArrayXd whitened;
  for (Eigen::Index first = 0; first < rows.position.size(); first += kRowsAtOnce) {
    const Eigen::Index count = std::min(kRowsAtOnce, rows.position.size() - first);
    whitened = by_position * rows.position.segment(first, count) +
               by_orientation * rows.orientation.segment(first, count);
    take(first, count, whitened);
  }
}

// Up to a constant: the sum over the rows of
//     -m log sigma - (d / 2) log v - loss(s) / (2 v)
//     + log Gamma((nu + d) / 2) - log Gamma(nu / 2) - (d / 2) log(nu / 2).
double log_likelihood(const Rows& rows, const ReadingSigma& sigma, double dof) {
  const int d = rows.size.all();
  const auto n = static_cast<double>(rows.position.size());
  double value = -rows.size.position * n * std::log(sigma.position);
  if (rows.size.orientation > 0) value -= rows.size.orientation * n * std::log(sigma.orientation);
  for_each_whitened(rows, sigma, [&](Eigen::Index first, Eigen::Index count, const auto& s) {
    const auto v = rows.variance.segment(first, count);
    value -= dof > 0 ? 0.5 * (dof + d) * (1 + s / (dof * v)).log().sum() + 0.5 * d * v.log().sum()
                     : 0.5 * (s / v).sum();
  });
  if (dof > 0)
    value += n * (log_gamma(0.5 * (dof + d)) - log_gamma(0.5 * dof) - 0.5 * d * std::log(dof / 2));
  return value;
}

// Expectation-maximisation of sigma under a law; see describe_residuals(). At the maximum of the
// likelihood the sum of the weights is known. Divided by it instead of by the number of rows, sigma
// converges in a third of the rounds (Kent, Tyler, Vardi, "A curious likelihood identity for the
// multivariate t-distribution", 1994).
ReadingSigma most_likely_sigma(const Rows& rows, ReadingSigma sigma, double dof,
                               const Eigen::Array2d& correction) {
  const int d = rows.size.all();
  double explained = rows.size.position / correction[0];  // mean of weight * s
  if (rows.size.orientation > 0) explained += rows.size.orientation / correction[1];
  for (int round = 0; round < (dof > 0 ? kMaxRoundsOfSigma : 1); ++round) {
    const ReadingSigma before = sigma;
    Eigen::Array2d sum = Eigen::Array2d::Zero();
    double counted = 0;
    Eigen::ArrayXd weight;  // over v
    for_each_whitened(rows, sigma, [&](Eigen::Index first, Eigen::Index count, const auto& s) {
      const auto v = rows.variance.segment(first, count);
      if (dof > 0)
        weight = (dof + d) / (dof * v + s);
      else
        weight = v.inverse();
      sum[0] += (weight * rows.position.segment(first, count)).sum();
      sum[1] += (weight * rows.orientation.segment(first, count)).sum();
      counted += (weight * v).sum();
    });
    if (dof > 0) counted *= dof / (dof + d - explained);
    sigma.position =
        std::max(kMinSigma, std::sqrt(correction[0] * sum[0] / (rows.size.position * counted)));
    if (rows.size.orientation > 0)
      sigma.orientation = std::max(
          kMinSigma, std::sqrt(correction[1] * sum[1] / (rows.size.orientation * counted)));
    if (std::abs(sigma.position - before.position) < kSigmaTolerance * before.position &&
        std::abs(sigma.orientation - before.orientation) < kSigmaTolerance * before.orientation)
      break;
  }
  return sigma;
}

}  // namespace

double ReadingLaw::weight(double squared_norm, int dimension, double row_variance) const {
  if (degrees_of_freedom <= 0) return 1.0;
  return counted_variance(row_variance) / row_variance * (degrees_of_freedom + dimension) /
         (degrees_of_freedom + squared_norm / row_variance);
}

double ReadingLaw::loss(double squared_norm, int dimension, double row_variance) const {
  if (degrees_of_freedom <= 0) return squared_norm;
  return counted_variance(row_variance) * (degrees_of_freedom + dimension) *
         std::log1p(squared_norm / (row_variance * degrees_of_freedom));
}

std::vector<double> pose_variances(const Campaign& campaign, const std::vector<double>& norms,
                                   int dimension) {
  const size_t poses = campaign.poses_by_quantity();
  // Each reading is the only one of its pose.
  if (campaign.anchor.empty() && !campaign.has_coordinates() && !campaign.has_touches() &&
      poses >= norms.size())
    return {};
  constexpr double kSmallest = 1e-12;  // the logarithm of an exact reading
  const auto log_of = [&](int row) {
    return std::log(std::max(norms[row] / dimension, kSmallest));
  };
  std::vector<double> sum(poses, 0.0);
  std::vector<int> readings(poses, 0);
  for (int row = 0; row < campaign.rows(); ++row) {
    sum[campaign.pose_by_quantity(row)] += log_of(row);
    ++readings[campaign.pose_by_quantity(row)];
  }
  std::vector<double> variances(norms.size(), 1.0);
  for (int row = 0; row < campaign.rows(); ++row) {
    const int pose = campaign.pose_by_quantity(row), others = readings[pose] - 1;
    if (others > 0) variances[row] = std::max(1.0, std::exp((sum[pose] - log_of(row)) / others));
  }
  return variances;
}

std::vector<double> pose_variances(const std::vector<Eigen::Vector2d>& norms,
                                   const Campaign& campaign, const ReadingSigma& sigma) {
  const ReadingSize size = campaign.reading_size();
  std::vector<double> whole;
  for (const Eigen::Vector2d& s : norms) whole.push_back(whitened(s, sigma, size));
  return pose_variances(campaign, whole, size.all());
}

ReadingLaw bounded_law(double degrees_of_freedom, std::vector<double> variance) {
  ReadingLaw law{degrees_of_freedom, std::move(variance)};
  constexpr double kTimes = 3, kUsual = 0.9;
  if (law.variance.empty()) return law;
  law.most_counted = kTimes * kTimes * quantile(law.variance, kUsual);
  return law;
}

bool is_close(const ReadingSigma& a, const ReadingSigma& b) {
  const auto same = [](double u, double v) { return std::abs(u - v) <= 1e-2 * std::max(u, v); };
  return same(a.position, b.position) && same(a.orientation, b.orientation);
}

ResidualDescription describe_residuals(const std::vector<Eigen::Vector2d>& norms,
                                       const Campaign& campaign, const ReadingSigma& start,
                                       const Eigen::Array2d& correction, bool robust) {
  const ReadingSize size = campaign.reading_size();
  const Rows alike(norms, {}, size);
  ResidualDescription best{most_likely_sigma(alike, start, 0, correction), {0}};
  if (!robust) return best;
  const std::vector<double> variance = pose_variances(norms, campaign, start);
  const Rows rows(norms, variance, size);
  double best_value = log_likelihood(alike, best.sigma, 0) + 0.5 * std::log(norms.size());
  constexpr std::array kFreedom{2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 30.0};
  struct Tried {
    double value, dof;
    ReadingSigma sigma;
  };
  for_ordered_blocks<Tried>(
      kFreedom.size(), 1,
      [&](int k, int) {
        const double dof = kFreedom[k];
        const ReadingSigma sigma = most_likely_sigma(rows, start, dof, correction);
        return Tried{log_likelihood(rows, sigma, dof), dof, sigma};
      },
      [&](const Tried& tried) {
        if (tried.value <= best_value) return;
        best_value = tried.value;
        best = {tried.sigma, {tried.dof, variance}};
      });
  // The variances of the poses are in units of sigma, and sigma depends on them: both are repeated
  // until sigma settles.
  for (int round = 0; round < kMaxRoundsOfLaw && best.law.degrees_of_freedom > 0; ++round) {
    best.law.variance = pose_variances(norms, campaign, best.sigma);
    const ReadingSigma before = best.sigma;
    best.sigma = most_likely_sigma(Rows(norms, best.law.variance, size), before,
                                   best.law.degrees_of_freedom, correction);
    if (is_close(best.sigma, before)) break;
  }
  best.law = bounded_law(best.law.degrees_of_freedom, std::move(best.law.variance));
  return best;
}

ReadingSigma sigma_with_prior(const ReadingSigma& sigma, const Eigen::Array2d& freedom,
                              const ReadingSigma& expected, bool has_orientation) {
  constexpr double kDeviation = 2, kCorrelation = 0.875;  // their ratio: deviation 1
  constexpr int kMaxSweeps = 200;                         // each leaves rho^2 of the error at most
  constexpr double kTolerance = 1e-9;
  const double rho = has_orientation ? kCorrelation : 0;
  const double variance = kDeviation * kDeviation * (1 - rho * rho);
  const std::array of_sigma{sigma.position, sigma.orientation};
  const std::array of_expected{expected.position, expected.orientation};
  std::array u{0.0, 0.0};
  double change = 1;
  for (int sweep = 0; sweep < kMaxSweeps && change > kTolerance; ++sweep) {
    change = 0;
    for (size_t k = 0; k < (has_orientation ? 2u : 1u); ++k) {
      const double ratio = of_sigma[k] / of_expected[k], mean = rho * u[1 - k];
      const auto f = freedom[k];
      double low = std::log(kMinSigma / of_expected[k]);
      double high = std::max(mean, std::log(ratio)) + 1;
      while (high - low > 0.1 * kTolerance) {
        const double middle = 0.5 * (low + high);
        const double excess =
            f * (ratio * ratio * std::exp(-2 * middle) - 1) - (middle - mean) / variance;
        (excess > 0 ? low : high) = middle;
      }
      change = std::max(change, std::abs(0.5 * (low + high) - u[k]));
      u[k] = 0.5 * (low + high);
    }
  }
  return {of_expected[0] * std::exp(u[0]),
          has_orientation ? of_expected[1] * std::exp(u[1]) : sigma.orientation};
}

ReadingSigma median_sigma(const std::vector<Eigen::Vector2d>& norms, const ReadingSize& size) {
  constexpr double kMedianOfChiSquare1 = 0.4549364231, kMedianOfChiSquare3 = 2.365973884;
  std::vector<double> position, orientation;
  for (const Eigen::Vector2d& s : norms) {
    position.push_back(s[0]);
    orientation.push_back(s[1]);
  }
  const auto sigma = [](const std::vector<double>& s, double median_of_noise) {
    return std::max(kMinSigma, std::sqrt(median(s) / median_of_noise));
  };
  return {sigma(position, size.position == 1 ? kMedianOfChiSquare1 : kMedianOfChiSquare3),
          sigma(orientation, kMedianOfChiSquare3)};
}

}  // namespace armtrue
