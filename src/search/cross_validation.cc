#include "search/cross_validation.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "calibration/pose_influence.h"
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

namespace {

// Equations of a fit, of basis, of columns that are added and of the residual, one after the other.
struct Equations {
  std::vector<int> pose;
  Eigen::MatrixXd basis, added;
  Eigen::VectorXd residual;
};

// Those of the rows, and for each pose what the rests of its replicates amount to: a rotation of
// the equations of the rests leaves of them the triangle of the columns added and the residual.
Equations with_rests(const Linearization& fit, const Eigen::MatrixXd& basis,
                     const Directions& added, const Eigen::VectorXd& residual) {
  const Replicates& replicates = fit.replicates();
  const int size = fit.row_size();
  const Eigen::Index columns = added.at_rows.cols();
  const RowsByPose rows = rows_by_pose(fit.pose());
  const Eigen::Index own = basis.rows(), all = own + rows.poses() * (columns + 1);
  Equations equations{{},
                      Eigen::MatrixXd::Zero(all, basis.cols()),
                      Eigen::MatrixXd::Zero(all, columns),
                      Eigen::VectorXd::Zero(all)};
  equations.basis.topRows(own) = basis;
  equations.added.topRows(own) = added.at_rows;
  equations.residual.head(own) = residual;
  for (int pose : fit.pose()) equations.pose.insert(equations.pose.end(), size, pose);
  for (int pose = 0; pose < rows.poses(); ++pose) {
    std::vector<Eigen::Index> rests;
    for (int k = rows.first[pose]; k < rows.first[pose + 1]; ++k)
      for (int i = replicates.first[rows.row[k]]; i < replicates.first[rows.row[k] + 1]; ++i)
        for (int axis = 0; axis < size; ++axis) rests.push_back(i * size + axis);
    Eigen::MatrixXd whole =
        Eigen::MatrixXd::Zero(std::max(std::ssize(rests), columns + 1), columns + 1);
    const auto count = std::ssize(rests);
    if (added.rests.rows() > 0)
      whole.topLeftCorner(count, columns) = added.rests(rests, Eigen::all);
    whole.col(columns).head(count) = replicates.rest.reshaped()(rests);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(whole);
    const Eigen::MatrixXd triangle =
        qr.matrixQR().topRows(columns + 1).triangularView<Eigen::Upper>();
    const Eigen::Index top = own + pose * (columns + 1);
    equations.added.middleRows(top, columns + 1) = triangle.leftCols(columns);
    equations.residual.segment(top, columns + 1) = triangle.col(columns);
    equations.pose.insert(equations.pose.end(), static_cast<size_t>(columns + 1),
                          fit.pose()[static_cast<size_t>(rows.row[rows.first[pose]])]);
  }
  return equations;
}

CrossValidation of_rows(const Linearization& fit, const Eigen::MatrixXd& basis,
                        const Directions& added, const Eigen::VectorXd& residual,
                        std::uint64_t seed) {
  if (!fit.replicates().any())
    return CrossValidation::of(fit.pose(), fit.row_size(), basis, added.at_rows, residual, seed);
  const Equations all = with_rests(fit, basis, added, residual);
  return CrossValidation::of(all.pose, 1, all.basis, all.added, all.residual, seed);
}

}  // namespace

CrossValidation CrossValidation::of(const Linearization& fit, const Directions& added,
                                    std::uint64_t seed) {
  return of_rows(fit, fit.basis(), added, fit.residual(), seed);
}

CrossValidation CrossValidation::of_effect(const Linearization& fit, int effect,
                                           std::uint64_t seed) {
  const Linearization::Loss loss = fit.without({effect});
  const Eigen::Index rank = loss.span.rows(), own = loss.span.cols();
  const Eigen::MatrixXd turn = Eigen::HouseholderQR<Eigen::MatrixXd>(loss.span).householderQ() *
                               Eigen::MatrixXd::Identity(rank, rank);
  const Directions added{fit.basis() * loss.span, {}};
  return of_rows(fit, fit.basis() * turn.rightCols(rank - own), added,
                 fit.residual() + added.at_rows * loss.residual, seed);
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

bool is_clearly_better(const Eigen::VectorXd& differences) {
  constexpr double kOneInThousand = 3.09;  // quantile 0.999 of the normal distribution
  const double mean = differences.mean();
  const auto count = static_cast<double>(differences.size());
  const double variance = (differences.array() - mean).square().sum() / (count - 1);
  return mean > kOneInThousand * std::sqrt(variance / count);
}

}  // namespace armtrue
