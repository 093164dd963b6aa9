#include "armtrue/statistics/autocorrelated_regression.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/statistics/distributions.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kMaxBins = 4096;  // more samples are summed in as many bins first
constexpr double kTimesSummed = 5;       // correlation times
constexpr double kSamplesPerCosine = 4;  // effective ones
constexpr double kDependent = 1e-12;     // eigenvalue of a normal matrix of unit diagonal: rounding
constexpr double kMinShare = 1e-6;       // of degrees of freedom, squared: below, they are many
constexpr double kMinCosines = 2, kMaxCosines = 24;  // beyond, Student's t hardly gains

// Columns and residual times the weights of an estimate, summed over bins of consecutive samples.
struct WeightedSums {
  Eigen::MatrixXd columns;   // bins x p
  Eigen::VectorXd residual;  // bins
  Eigen::VectorXd passed;    // share of the squared weights before the middle of each bin
  double samples_per_bin = 1;
};

WeightedSums sum_weighted(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                          const Eigen::VectorXd& weight) {
  const Eigen::Index n = weight.size(), width = (n + kMaxBins - 1) / kMaxBins;
  const Eigen::Index bins = (n + width - 1) / width;
  WeightedSums sums{Eigen::MatrixXd(bins, columns.cols()), Eigen::VectorXd(bins),
                    Eigen::VectorXd(bins), static_cast<double>(width)};
  const double total = weight.squaredNorm();
  double passed = 0;
  for (Eigen::Index b = 0; b < bins; ++b) {
    const Eigen::Index first = b * width, count = std::min(width, n - first);
    const auto w = weight.segment(first, count);
    sums.columns.row(b) = w.transpose() * columns.middleRows(first, count);
    sums.residual[b] = w.dot(residual.segment(first, count));
    const double share = w.squaredNorm() / total;
    sums.passed[b] = passed + share / 2;
    passed += share;
  }
  return sums;
}

// Integrated correlation time of the residual, in samples: the number of samples that count as one
// independent sample.
double correlation_time(const WeightedSums& sums) {
  const auto bins = static_cast<int>(sums.residual.size());
  const double power = sums.residual.squaredNorm();
  if (power == 0) return sums.samples_per_bin;
  double time = 1;
  int lag = 1;
  for (; lag < bins && lag < kTimesSummed * time; ++lag)
    time += 2 * sums.residual.head(bins - lag).dot(sums.residual.tail(bins - lag)) / power;
  // Each fitted column lowers each of the 2 lag + 1 correlations by time / bins.
  const auto fitted_lags = static_cast<double>(sums.columns.cols() * (2 * lag + 1));
  time = std::max(time, 1.0) * (1 + fitted_lags / bins);
  return time * sums.samples_per_bin;
}

// Variance of the coefficient whose value is weight' * response, and the degrees of freedom that it
// was estimated with.
struct Spread {
  double variance = 0, freedom = 0;
};

// `residual` is what `fitted`, orthonormal columns, left.
Spread spread(const Eigen::MatrixXd& fitted, const Eigen::VectorXd& residual,
              const Eigen::VectorXd& weight) {
  const WeightedSums sums = sum_weighted(fitted, residual, weight);
  const double total = weight.squaredNorm();
  const double samples = total * total / weight.array().square().square().sum();
  const double freedom = std::floor(
      std::clamp(samples / (kSamplesPerCosine * correlation_time(sums)), kMinCosines, kMaxCosines));
  const auto cosines = static_cast<int>(freedom);
  // Cosines of the weights' own time have nothing in common with the estimate.
  Eigen::MatrixXd cosine(sums.passed.size(), cosines);
  for (int j = 0; j < cosines; ++j)
    cosine.col(j) = (std::numbers::pi * (j + 1) * sums.passed).array().cos();
  const Eigen::MatrixXd on_columns = cosine.transpose() * sums.columns;
  const Eigen::VectorXd on_residual = cosine.transpose() * sums.residual;
  // Weighted cosines are orthogonal in their own time, each of square norm total / 2; what they
  // share with the columns the residual cannot show.
  Eigen::MatrixXd gram = -on_columns * on_columns.transpose();
  gram.diagonal().array() += total / 2;
  const double energy = on_residual.dot(gram.ldlt().solve(on_residual));
  return {std::max(energy, 0.0) / freedom * total, freedom};
}

// A value with the variance that the residual shows and a known one beside it.
Estimate estimate(double value, const Spread& shown, double known) {
  const double variance = shown.variance + known, std = std::sqrt(variance);
  const double share = variance > 0 ? shown.variance / variance : 1;
  const double freedom = shown.freedom / std::max(share * share, kMinShare);
  const double half_width = student_t_quantile(0.975, freedom) * std;
  return {value, std, {value - half_width, value + half_width}};
}

// Of a normal matrix, its columns scaled alike.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& normal) {
  const auto dependent = [] { throw std::invalid_argument("regression: dependent columns"); };
  if (!(normal.diagonal().minCoeff() > 0)) dependent();
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{
      Eigen::MatrixXd(scale.asDiagonal() * normal * scale.asDiagonal())};
  if (!(solver.eigenvalues()[0] > kDependent)) dependent();
  return scale.asDiagonal() * solver.eigenvectors() *
         solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose() *
         scale.asDiagonal();
}

// Orthonormal columns that span those of both; what depends on others adds none.
Eigen::MatrixXd basis_of(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& shared) {
  const Eigen::Index p = columns.cols(), m = shared.cols();
  Eigen::MatrixXd normal(p + m, p + m);
  normal << columns.transpose() * columns, columns.transpose() * shared,
      shared.transpose() * columns, shared.transpose() * shared;
  const Eigen::VectorXd scale = normal.diagonal().unaryExpr(
      [](double square) { return square > 0 ? 1 / std::sqrt(square) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{
      Eigen::MatrixXd(scale.asDiagonal() * normal * scale.asDiagonal())};
  const Eigen::Index rank = (solver.eigenvalues().array() > kDependent).count();
  const Eigen::MatrixXd orthonormal =
      scale.asDiagonal() * solver.eigenvectors().rightCols(rank) *
      solver.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
  return columns * orthonormal.topRows(p) + shared * orthonormal.bottomRows(m);
}

}  // namespace

Regression regress_autocorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& response,
                                  const Eigen::MatrixXd& noise, const Eigen::MatrixXd& shared) {
  const Eigen::Index n = columns.rows(), p = columns.cols();
  if (response.size() != n || noise.rows() != p || noise.cols() != p || shared.rows() != n)
    throw std::invalid_argument("regression: sizes disagree");
  if (n <= p) throw std::invalid_argument("regression: fewer samples than unknowns");
  const Eigen::MatrixXd normal = columns.transpose() * columns - static_cast<double>(n) * noise;
  const Eigen::MatrixXd inverse_normal = inverse_of(normal);
  const Eigen::VectorXd value = inverse_normal * (columns.transpose() * response);
  Regression result;
  result.residual = response - columns * value;
  // What the columns themselves explain of the residual is the correction for their noise; what the
  // shared errors explain would count twice.
  const Eigen::MatrixXd fitted = basis_of(columns, shared);
  const Eigen::VectorXd unexplained =
      result.residual - fitted * (fitted.transpose() * result.residual);
  for (Eigen::Index k = 0; k < p; ++k) {
    const Eigen::VectorXd weight = columns * inverse_normal.col(k);
    const double known = (weight.transpose() * shared).squaredNorm();
    result.coefficients.push_back(estimate(value[k], spread(fitted, unexplained, weight), known));
  }
  return result;
}

}  // namespace armtrue
