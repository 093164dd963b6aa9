#include "cross_validation.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "ordered_blocks.h"
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

  // The predictors are orthonormal, and the residual is orthogonal to the basis.
  Eigen::VectorXd whole_slope = Eigen::VectorXd::Zero(predictors.cols());
  whole_slope.tail(added.cols()) = added.transpose() * whole_residual;
  const int folds = std::min<int>(kFolds, static_cast<int>(poses.size()));
  struct OfPose {
    double before, gain;
  };
  std::vector<OfPose> losses;
  for_ordered_blocks<std::vector<OfPose>>(
      folds, 1,
      [&](int f, int) {
        std::vector<int> indices;
        std::vector<std::pair<int, int>> extents;  // of each pose left out, within indices
        for (size_t i = static_cast<size_t>(f); i < poses.size(); i += static_cast<size_t>(folds)) {
          const int begin = static_cast<int>(indices.size());
          for (int row : rows_of_pose.at(poses[i]))
            for (int k = 0; k < size; ++k) indices.push_back(row * size + k);
          extents.emplace_back(begin, static_cast<int>(indices.size()) - begin);
        }
        const Eigen::MatrixXd left_out = predictors(indices, Eigen::all);
        const Eigen::VectorXd residual = whole_residual(indices);
        // All readings less the ones left out.
        Eigen::MatrixXd gram = -left_out.transpose() * left_out;
        gram.diagonal().array() += 1 + 1e-10;
        const Eigen::VectorXd slope = whole_slope - left_out.transpose() * residual;
        const Eigen::VectorXd without =
            residual -
            left_out.leftCols(rank) * gram.topLeftCorner(rank, rank).ldlt().solve(slope.head(rank));
        const Eigen::VectorXd with = residual - left_out * gram.ldlt().solve(slope);
        std::vector<OfPose> left_out_poses;
        for (const auto& [begin, count] : extents) {
          const double before = without.segment(begin, count).squaredNorm();
          left_out_poses.push_back({before, before - with.segment(begin, count).squaredNorm()});
        }
        return left_out_poses;
      },
      [&](const std::vector<OfPose>& fold) {
        losses.insert(losses.end(), fold.begin(), fold.end());
      });
  const double n = static_cast<double>(losses.size());
  double per_pose = 0, mean = 0, squares = 0;
  for (const OfPose& pose : losses) {
    per_pose += pose.before / n;
    mean += pose.gain / n;
  }
  for (const OfPose& pose : losses) squares += (pose.gain - mean) * (pose.gain - mean);
  if (per_pose <= 0 || n < 2) return {};
  return {mean / per_pose, std::sqrt(squares / (n - 1) / n) / per_pose};
}

}  // namespace armtrue
