#include "path/smoothing_spline.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <numbers>
#include <vector>

namespace armtrue {
namespace {

// The weight in min sum (y - g)^2 + weight * integral of g''^2, samples one apart. The response
// 1 / (1 + weight w^4), at low frequencies, is 1 / sqrt 2 at the cut-off.
double penalty(double cutoff, double rate) {
  const double w = 2 * std::numbers::pi * cutoff / rate;
  return (std::numbers::sqrt2 - 1) / (w * w * w * w);
}

}  // namespace

Eigen::MatrixXd smoothing_spline(const Eigen::MatrixXd& samples, double cutoff, double rate) {
  const Eigen::Index n = samples.cols();
  if (n < 3) return samples;
  const double weight = penalty(cutoff, rate);
  // (R + weight Q'Q) c = Q'y, g = y - weight Q c, with c the second derivatives inside, R their
  // Gram matrix 1/6 2/3 1/6 and Q the second difference 1 -2 1.
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * n);
  for (Eigen::Index i = 0; i < n - 2; ++i) {
    entries.emplace_back(i, i, 2.0 / 3 + 6 * weight);
    if (i > 0) entries.emplace_back(i, i - 1, 1.0 / 6 - 4 * weight);
    if (i > 1) entries.emplace_back(i, i - 2, weight);
  }
  Eigen::SparseMatrix<double> matrix(n - 2, n - 2);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower,
                              Eigen::NaturalOrdering<int>>
      solver(matrix);
  const Eigen::MatrixXd y = samples.transpose();
  const Eigen::MatrixXd differences =
      y.topRows(n - 2) - 2 * y.middleRows(1, n - 2) + y.bottomRows(n - 2);
  const Eigen::MatrixXd c = solver.solve(differences);
  Eigen::MatrixXd smooth = y;
  smooth.topRows(n - 2) -= weight * c;
  smooth.middleRows(1, n - 2) += 2 * weight * c;
  smooth.bottomRows(n - 2) -= weight * c;
  return smooth.transpose();
}

double smoothing_spline_noise_share(double cutoff, double rate) {
  const double weight = penalty(cutoff, rate);
  constexpr int kSteps = 4096;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double w = std::numbers::pi * (k + 0.5) / kSteps;
    const double difference = 2 - 2 * std::cos(w);  // of Q, squared: |2 cos w - 2|^2
    const double gram = 2.0 / 3 + std::cos(w) / 3;
    const double response = gram / (gram + weight * difference * difference);
    sum += response * response;
  }
  return sum / kSteps;
}

}  // namespace armtrue
