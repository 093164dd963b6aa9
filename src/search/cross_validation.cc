#include "search/cross_validation.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

constexpr int kFolds = 10;
// Ridge: shrinks a column that only the left-out poses determine. A knot of a curve with a single
// pose near it cannot be predicted from the others, and that pose alone would decide.
constexpr double kShownByOthers = 0.01;

}  // namespace

CrossValidation CrossValidation::of(const Linearization& fit, const Eigen::MatrixXd& added,
                                    std::uint64_t seed) {
  return of(fit.pose(), fit.row_size(), fit.basis(), added, fit.residual(), seed);
}

CrossValidation CrossValidation::of_effect(const Linearization& fit, int effect,
                                           std::uint64_t seed) {
  const Linearization::Loss loss = fit.without({effect});
  const Eigen::Index rank = loss.span.rows(), own = loss.span.cols();
  const Eigen::MatrixXd turn = Eigen::HouseholderQR<Eigen::MatrixXd>(loss.span).householderQ() *
                               Eigen::MatrixXd::Identity(rank, rank);
  const Eigen::MatrixXd added = fit.basis() * loss.span;
  return of(fit.pose(), fit.row_size(), fit.basis() * turn.rightCols(rank - own), added,
            fit.residual() + added * loss.residual, seed);
}

namespace {

// Loss of a pose that was left out, and how much less it is with the columns added.
struct OfPose {
  double before, gain;
};

CrossValidation mean_gain(const std::vector<OfPose>& losses) {
  const double n = static_cast<double>(losses.size());
  double per_pose = 0, mean = 0, squares = 0;
  for (const OfPose& one : losses) {
    per_pose += one.before / n;
    mean += one.gain / n;
  }
  for (const OfPose& one : losses) squares += (one.gain - mean) * (one.gain - mean);
  if (per_pose <= 0 || n < 2) return {};
  return {mean / per_pose, std::sqrt(squares / (n - 1) / n) / per_pose};
}

}  // namespace

CrossValidation CrossValidation::of(const std::vector<int>& pose, int row_size,
                                    const Eigen::MatrixXd& basis, const Eigen::MatrixXd& added,
                                    const Eigen::VectorXd& whole_residual, std::uint64_t seed) {
  const int rank = static_cast<int>(basis.cols());
  Eigen::MatrixXd predictors(basis.rows(), rank + added.cols());
  predictors << basis, added;

  std::map<int, std::vector<int>> rows_of_pose;
  for (size_t row = 0; row < pose.size(); ++row)
    rows_of_pose[pose[row]].push_back(static_cast<int>(row));
  std::vector<int> poses;
  for (const auto& [id, rows] : rows_of_pose) poses.push_back(id);
  shuffle(poses, seed);

  // The predictors are orthonormal, and the residual is orthogonal to the basis.
  Eigen::VectorXd whole_slope = Eigen::VectorXd::Zero(predictors.cols());
  whole_slope.tail(added.cols()) = added.transpose() * whole_residual;
  const int folds = std::min<int>(kFolds, static_cast<int>(poses.size()));
  std::vector<OfPose> losses;
  for_ordered_blocks<std::vector<OfPose>>(
      folds, 1,
      [&](int f, int) {
        std::vector<int> indices;
        std::vector<std::pair<int, int>> extents;  // of each pose left out, within indices
        for (size_t i = static_cast<size_t>(f); i < poses.size(); i += static_cast<size_t>(folds)) {
          const int begin = static_cast<int>(indices.size());
          for (int row : rows_of_pose.at(poses[i]))
            for (int k = 0; k < row_size; ++k) indices.push_back(row * row_size + k);
          extents.emplace_back(begin, static_cast<int>(indices.size()) - begin);
        }
        const Eigen::MatrixXd left_out = predictors(indices, Eigen::all);
        const Eigen::VectorXd residual = whole_residual(indices);
        // All readings less the ones left out.
        Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(left_out.cols(), left_out.cols());
        gram.selfadjointView<Eigen::Lower>().rankUpdate(left_out.transpose(), -1.0);
        gram.diagonal().array() += 1 + kShownByOthers;
        const Eigen::VectorXd slope = whole_slope - left_out.transpose() * residual;
        // Its factor has that without the columns added as its corner.
        const Eigen::MatrixXd factor = Eigen::LLT<Eigen::MatrixXd>(gram).matrixL();
        const auto left = [&](Eigen::Index unknowns) -> Eigen::VectorXd {
          const auto corner =
              factor.topLeftCorner(unknowns, unknowns).triangularView<Eigen::Lower>();
          Eigen::VectorXd solution = slope.head(unknowns);
          corner.solveInPlace(solution);
          corner.transpose().solveInPlace(solution);
          return residual - left_out.leftCols(unknowns) * solution;
        };
        const Eigen::VectorXd without = left(rank), with = left(slope.size());
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
  return mean_gain(losses);
}

}  // namespace armtrue
