#include "search/cross_validation.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
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

// Loss of a pose that was left out, and how much less it is with the columns added.
struct OfPose {
  double before = 0, gain = 0;
};

GainLeftOut mean_gain(const std::vector<OfPose>& losses) {
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

CrossValidation::CrossValidation(const Linearization& fit, std::uint64_t seed) : fit_(fit) {
  const GroupedRows rows = grouped_rows(fit.pose());
  std::vector<int> poses(rows.groups());
  std::iota(poses.begin(), poses.end(), 0);
  shuffle(poses, seed);
  folds_.resize(std::min<size_t>(kFolds, poses.size()));
  for_ordered_blocks<int>(
      static_cast<int>(folds_.size()), 1,
      [&](int number, int) {
        const size_t f = number;
        std::vector<int> own;
        for (size_t i = f; i < poses.size(); i += folds_.size()) own.push_back(poses[i]);
        folds_[f] = fold_of(own, rows);
        return 0;
      },
      [](int) {});
}

CrossValidation::Fold CrossValidation::fold_of(const std::vector<int>& poses,
                                               const GroupedRows& rows) const {
  const Replicates& replicates = fit_.replicates();
  const int size = fit_.row_size();
  Fold fold;
  fold.poses = static_cast<int>(poses.size());
  for (int p = 0; p < fold.poses; ++p)
    for (int k = rows.first[poses[p]]; k < rows.first[poses[p] + 1]; ++k) {
      const int row = rows.row[k];
      for (int axis = 0; axis < size; ++axis) fold.equations.push_back(row * size + axis);
      fold.pose_of_equation.insert(fold.pose_of_equation.end(), size, p);
      if (!replicates.any()) continue;
      for (int i = replicates.first[row] * size; i < replicates.first[row + 1] * size; ++i)
        fold.rests.push_back(i);
      fold.pose_of_rest.resize(fold.rests.size(), p);
    }
  fold.basis = fit_.basis()(fold.equations, Eigen::all);
  // All readings, of which the basis is orthonormal, less the ones left out.
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(fold.basis.cols(), fold.basis.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(fold.basis.transpose(), -1.0);
  gram.diagonal().array() += 1 + kShownByOthers;
  fold.others.compute(gram);
  return fold;
}

template <typename ErrorsOf>
GainLeftOut CrossValidation::gain_by(const ErrorsOf& errors_of) const {
  std::vector<OfPose> losses;
  for_ordered_blocks<std::vector<OfPose>>(
      static_cast<int>(folds_.size()), 1,
      [&](int f, int) {
        const Fold& fold = folds_[f];
        const Errors errors = errors_of(fold);
        std::vector<OfPose> of_fold(fold.poses);
        const auto add = [&](int pose, double without, double with) {
          OfPose& loss = of_fold[pose];
          loss.before += without * without;
          loss.gain += without * without - with * with;
        };
        for (size_t k = 0; k < fold.equations.size(); ++k)
          add(fold.pose_of_equation[k], errors.without[k], errors.with[k]);
        for (size_t k = 0; k < fold.rests.size(); ++k)
          add(fold.pose_of_rest[k], errors.rests_without[k], errors.rests_with[k]);
        return of_fold;
      },
      [&](const std::vector<OfPose>& fold) {
        losses.insert(losses.end(), fold.begin(), fold.end());
      });
  return mean_gain(losses);
}

// The unknowns x of the basis B and y of the columns A that the other poses give, with the Gram
// matrices of both at the others, G = L L^T of B, C = B^T A, D of A:
//     (D - C^T G^-1 C) y = a - C^T G^-1 b,  x = G^-1 (b - C y).
GainLeftOut CrossValidation::of(const Directions& added) const {
  const Eigen::VectorXd& whole = fit_.residual();
  const Eigen::VectorXd whole_rests = fit_.replicates().rest.reshaped();
  // The residual is orthogonal to the basis.
  Eigen::VectorXd slope = added.at_rows.transpose() * whole;
  const bool has_rests = added.rests.rows() > 0;
  if (has_rests) slope += added.rests.transpose() * whole_rests;
  return gain_by([&](const Fold& fold) {
    const Eigen::MatrixXd columns = added.at_rows(fold.equations, Eigen::all);
    const Eigen::VectorXd residual = whole(fold.equations);
    Errors errors{residual, {}, whole_rests(fold.rests), {}};
    const Eigen::MatrixXd of_basis =
        -fold.others.solve(Eigen::MatrixXd(fold.basis.transpose() * columns));
    const Eigen::VectorXd alone =
        -fold.others.solve(Eigen::VectorXd(fold.basis.transpose() * residual));  // x
    errors.without -= fold.basis * alone;
    // What the basis leaves of the columns.
    const Eigen::MatrixXd beside = columns - fold.basis * of_basis;
    Eigen::MatrixXd gram = -(columns.transpose() * beside);
    gram.diagonal().array() += 1 + kShownByOthers;
    Eigen::VectorXd own = slope - columns.transpose() * errors.without;
    Eigen::MatrixXd rests(0, columns.cols());
    if (has_rests) {
      rests = added.rests(fold.rests, Eigen::all);
      gram.noalias() -= rests.transpose() * rests;
      own.noalias() -= rests.transpose() * errors.rests_without;
    }
    const Eigen::VectorXd value = gram.llt().solve(own);
    errors.with = errors.without - beside * value;
    errors.rests_with = errors.rests_without;
    if (has_rests) errors.rests_with -= rests * value;
    return errors;
  });
}

// The other poses give x = G^-1 b with the effect. Without it x has no component in the span S of
// the directions that only the effect has:
//     x - G^-1 S (S^T G^-1 S)^-1 S^T x.
GainLeftOut CrossValidation::of_effect(int effect) const {
  const Linearization::Loss loss = fit_.without({effect});
  const Eigen::VectorXd lost = loss.span * loss.residual;
  const Eigen::VectorXd whole = fit_.residual() + fit_.basis() * lost;
  const Eigen::VectorXd whole_rests = fit_.replicates().rest.reshaped();
  return gain_by([&](const Fold& fold) {
    const Eigen::VectorXd residual = whole(fold.equations), rests = whole_rests(fold.rests);
    const Eigen::VectorXd with =
        fold.others.solve(Eigen::VectorXd(lost - fold.basis.transpose() * residual));
    const Eigen::VectorXd errors_with = residual - fold.basis * with;
    Errors errors{errors_with, errors_with, rests, rests};
    if (loss.span.cols() == 0) return errors;
    const Eigen::MatrixXd of_span = fold.others.solve(loss.span);
    const Eigen::MatrixXd shown = loss.span.transpose() * of_span;
    errors.without +=
        fold.basis * (of_span * shown.llt().solve(Eigen::VectorXd(loss.span.transpose() * with)));
    return errors;
  });
}

}  // namespace armtrue
