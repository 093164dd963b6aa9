#include "cross_validation.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "shuffle.h"

namespace armtrue {
namespace {

constexpr int kFolds = 10;

}  // namespace

CrossValidation CrossValidation::of(const Linearization& fit, const Eigen::MatrixXd& added,
                                    std::uint64_t seed) {
  return of(fit, fit.basis(), added, fit.residual(), seed);
}

CrossValidation CrossValidation::of_effect(const Linearization& fit, int effect,
                                           std::uint64_t seed) {
  const Linearization::Loss loss = fit.without({effect});
  const Eigen::Index rank = loss.span.rows(), own = loss.span.cols();
  const Eigen::MatrixXd turn = Eigen::HouseholderQR<Eigen::MatrixXd>(loss.span).householderQ() *
                               Eigen::MatrixXd::Identity(rank, rank);
  const Eigen::MatrixXd added = fit.basis() * loss.span;
  return of(fit, fit.basis() * turn.rightCols(rank - own), added,
            fit.residual() + added * loss.residual, seed);
}

// `added` orthonormal beside `basis`; `residual` orthogonal to `basis`.
CrossValidation CrossValidation::of(const Linearization& fit, const Eigen::MatrixXd& basis,
                                    const Eigen::MatrixXd& added,
                                    const Eigen::VectorXd& whole_residual, std::uint64_t seed) {
  const int size = fit.row_size(), rank = static_cast<int>(basis.cols());
  Eigen::MatrixXd predictors(basis.rows(), rank + added.cols());
  predictors << basis, added;

  std::map<int, std::vector<int>> rows_of_pose;
  for (int row = 0; row < fit.rows(); ++row) rows_of_pose[fit.pose()[row]].push_back(row);
  std::vector<int> poses;
  for (const auto& [pose, rows] : rows_of_pose) poses.push_back(pose);
  shuffle(poses, seed);

  const Eigen::MatrixXd whole_gram = predictors.transpose() * predictors;
  const Eigen::VectorXd whole_slope = predictors.transpose() * whole_residual;
  const int folds = std::min<int>(kFolds, static_cast<int>(poses.size()));
  std::vector<double> gains;
  double before_total = 0;
  for (int f = 0; f < folds; ++f) {
    std::vector<int> indices;
    std::vector<std::pair<int, int>> extents;  // of each pose left out, within indices
    for (size_t i = static_cast<size_t>(f); i < poses.size(); i += static_cast<size_t>(folds)) {
      const int begin = static_cast<int>(indices.size());
      for (int row : rows_of_pose[poses[i]])
        for (int k = 0; k < size; ++k) indices.push_back(row * size + k);
      extents.emplace_back(begin, static_cast<int>(indices.size()) - begin);
    }
    const Eigen::MatrixXd left_out = predictors(indices, Eigen::all);
    const Eigen::VectorXd residual = whole_residual(indices);
    // All readings less the ones left out.
    Eigen::MatrixXd gram = whole_gram - left_out.transpose() * left_out;
    gram.diagonal().array() += 1e-10;
    const Eigen::VectorXd slope = whole_slope - left_out.transpose() * residual;
    const Eigen::VectorXd without =
        residual -
        left_out.leftCols(rank) * gram.topLeftCorner(rank, rank).ldlt().solve(slope.head(rank));
    const Eigen::VectorXd with = residual - left_out * gram.ldlt().solve(slope);
    for (const auto& [begin, count] : extents) {
      const double before = without.segment(begin, count).squaredNorm();
      before_total += before;
      gains.push_back(before - with.segment(begin, count).squaredNorm());
    }
  }
  double mean = 0, squares = 0;
  for (double gain : gains) mean += gain;
  const double n = static_cast<double>(gains.size());
  mean /= n;
  for (double gain : gains) squares += (gain - mean) * (gain - mean);
  const double per_pose = before_total / n;
  if (per_pose <= 0 || n < 2) return {};
  return {mean / per_pose, std::sqrt(squares / (n - 1) / n) / per_pose};
}

}  // namespace armtrue
