#include "armtrue/identification/autocorrelated_regression.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace armtrue {
namespace {

constexpr Eigen::Index kMostBins = 4096;  // the correlation of more samples is that of their sums
constexpr double kWindow = 5;             // correlation times summed over
constexpr double kSamplesPerCosine = 4;   // effective ones
constexpr double kDependent = 1e-12;  // eigenvalue of a normal matrix of unit diagonal: rounding
constexpr double kFewestCosines = 2, kMostCosines = 24;  // beyond, Student's t hardly gains

// Integrated correlation time, in samples, of what is left of a series by `fitted` columns: how
// many make one independent one.
double correlation_time(const Eigen::VectorXd& series, Eigen::Index fitted) {
  const Eigen::Index width = (series.size() + kMostBins - 1) / kMostBins;
  const Eigen::Index bins = series.size() / width;
  Eigen::VectorXd sums(bins);
  for (Eigen::Index b = 0; b < bins; ++b) sums[b] = series.segment(b * width, width).sum();
  const double power = sums.squaredNorm();
  if (power == 0) return 1;
  double time = 1;
  Eigen::Index lag = 1;
  for (; lag < bins && static_cast<double>(lag) < kWindow * time; ++lag)
    time += 2 * sums.head(bins - lag).dot(sums.tail(bins - lag)) / power;
  // Each fitted column leaves each of the 2 lag + 1 correlations short by time / bins.
  const auto fitted_lags = static_cast<double>(fitted * (2 * lag + 1));
  time = std::max(time, 1.0) * (1 + fitted_lags / static_cast<double>(bins));
  return time * static_cast<double>(width);
}

// Projections on the cosines 1, 2, ... of the weights' own time, so that a cosine has nothing in
// common with the estimate: `columns` and `residual` summed with weight * cosine.
struct Projections {
  Eigen::MatrixXd columns;   // cosines x p
  Eigen::VectorXd residual;  // cosines
};

Projections project(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                    const Eigen::VectorXd& weight, Eigen::Index cosines) {
  Projections sums{Eigen::MatrixXd::Zero(cosines, columns.cols()), Eigen::VectorXd::Zero(cosines)};
  const double total = weight.squaredNorm();
  double passed = 0;
  for (Eigen::Index i = 0; i < weight.size(); ++i) {
    const double share = weight[i] * weight[i] / total;
    const double base = std::cos(std::numbers::pi * (passed + share / 2));
    passed += share;
    double before = weight[i], cosine = weight[i] * base;  // Chebyshev's recurrence
    for (Eigen::Index j = 0; j < cosines; ++j) {
      sums.columns.row(j) += cosine * columns.row(i);
      sums.residual[j] += cosine * residual[i];
      const double next = 2 * base * cosine - before;
      before = cosine;
      cosine = next;
    }
  }
  return sums;
}

// Standard deviation and half width of the interval of the coefficient whose value is
// weight' * response.
struct Spread {
  double std = 0, half_width = 0;
};

Spread spread(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& inverse_normal,
              const Eigen::VectorXd& residual, const Eigen::VectorXd& weight) {
  const double total = weight.squaredNorm();
  const double samples = total * total / weight.array().square().square().sum();
  const double wanted = samples / (kSamplesPerCosine *
                                   correlation_time(weight.cwiseProduct(residual), columns.cols()));
  const auto cosines = static_cast<Eigen::Index>(std::clamp(wanted, kFewestCosines, kMostCosines));
  const Projections sums = project(columns, residual, weight, cosines);
  // Weighted cosines are orthogonal in their own time, each of square norm total / 2; what they
  // share with the columns the residual cannot show.
  Eigen::MatrixXd gram = -sums.columns * inverse_normal * sums.columns.transpose();
  gram.diagonal().array() += total / 2;
  const double energy = sums.residual.dot(gram.ldlt().solve(sums.residual));
  const auto freedom = static_cast<double>(cosines);
  const double std = std::sqrt(std::max(energy, 0.0) / freedom * total);
  const boost::math::students_t law(freedom);
  return {std, std * boost::math::quantile(law, 0.975)};
}

// Of a normal matrix, its columns scaled alike.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& normal) {
  const auto dependent = [] { throw std::invalid_argument("regression: dependent columns"); };
  if (!(normal.diagonal().minCoeff() > 0)) dependent();
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * normal *
                                                              scale.asDiagonal());
  if (!(solver.eigenvalues()[0] > kDependent)) dependent();
  return scale.asDiagonal() * solver.eigenvectors() *
         solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose() *
         scale.asDiagonal();
}

}  // namespace

Regression regress_autocorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& response,
                                  const Eigen::MatrixXd& noise) {
  const Eigen::Index n = columns.rows(), p = columns.cols();
  if (response.size() != n || noise.rows() != p || noise.cols() != p)
    throw std::invalid_argument("regression: sizes disagree");
  if (n <= p) throw std::invalid_argument("regression: fewer samples than unknowns");
  const Eigen::MatrixXd observed = columns.transpose() * columns;
  const Eigen::MatrixXd normal = observed - static_cast<double>(n) * noise;
  const Eigen::MatrixXd inverse_normal = inverse_of(normal);
  const Eigen::VectorXd value = inverse_normal * (columns.transpose() * response);
  Regression result;
  result.residual = response - columns * value;
  // What the columns themselves explain of the residual is the correction for their noise.
  const Eigen::MatrixXd inverse_observed = inverse_of(observed);
  const Eigen::VectorXd unexplained =
      result.residual - columns * (inverse_observed * (columns.transpose() * result.residual));
  for (Eigen::Index k = 0; k < p; ++k) {
    const Eigen::VectorXd weight = columns * inverse_normal.col(k);
    const Spread s = spread(columns, inverse_observed, unexplained, weight);
    result.coefficients.push_back(
        {value[k], s.std, {value[k] - s.half_width, value[k] + s.half_width}});
  }
  return result;
}

}  // namespace armtrue
