#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "calibration/session_models.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {

/// A root of the inverse of the information: its product with its transpose is the inverse, but for
/// directions of which nothing is known.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& information);

/// What one pose, with all its readings, does to a fit. All is in coordinates of the unknowns in
/// which the fit's information is the unit matrix.
struct PoseInfluence {
  Eigen::VectorXd change;  ///< the fit with the pose less the fit without it, in one Newton step
  Eigen::MatrixXd alone;   ///< x directions that no other pose shows; nothing of them in `change`
};

/// `rows`: of the pose, whitened and weighted, times a root of the inverse of the information. The
/// residual counts as it would be if the pose took no part, (1 - leverage)^-1 of its own (CR3 of
/// Bell, McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage
/// samples", 2002): this makes up for a pose that bends the fit to itself.
PoseInfluence influence_of_pose(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                const Eigen::Ref<const Eigen::VectorXd>& residual);

/// The pose's residual as it would scatter if nothing had been fitted to it, (1 - leverage)^-1/2 of
/// its own (CR2 of the same source). `rows`: of the pose, in an orthonormal basis of the fit.
Eigen::VectorXd leverage_corrected_residual(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                            const Eigen::Ref<const Eigen::VectorXd>& residual);

/// Sums over poses, of which their covariance consists.
class InfluenceSums {
 public:
  void add(const PoseInfluence& pose);
  void add(const InfluenceSums& others);
  /// Cluster covariance by pose: (n - 1) / n of the squares about the mean. What only one pose
  /// shows no scatter between poses can tell: there its readings have `variance`, as independent
  /// ones would.
  Eigen::MatrixXd covariance(double mean_psi_derivative, double variance) const;

 private:
  int poses_ = 0;
  Eigen::VectorXd sum_;
  Eigen::MatrixXd squares_, alone_;
};

/// Under Student's t the sum of weights overstates how firmly the readings hold the fit: a reading
/// that moves away is held less. Mean of d(w r)/dr over that of w (Huber, "Robust statistics",
/// 1981, 7.6); 1 if Gaussian.
double mean_psi_derivative(const std::vector<double>& weights, double degrees_of_freedom,
                           int dimension);

/// Rows in the order of their poses; those of pose k from first[k] to before first[k + 1].
struct RowsByPose {
  std::vector<int> first, row;
  int poses() const { return static_cast<int>(first.size()) - 1; }
};
/// `pose`: its number, of each row; numbers without rows are left out.
RowsByPose rows_by_pose(const std::vector<int>& pose);
/// So many of them, evenly spread; all if there are no more.
RowsByPose some_poses(const RowsByPose& all, int count);

/// Calls `add(sums, influence, rows)` for each pose, into a Sums for each block of them, and hands
/// those to `join` in the order of the poses. `root`: inverse_root() of the information; `rows` as
/// for influence_of_pose().
template <typename Sums, typename Add, typename Join>
void for_each_pose(const SessionModels::At& at, const std::vector<double>& weights,
                   const Eigen::MatrixXd& root, const RowsByPose& rows, const Add& add,
                   const Join& join) {
  constexpr int kPosesPerBlock = 32, kMaxBlocks = 256, kRowsAtOnce = 40;
  const int count = rows.poses(), size = at.models().row_size();
  const Eigen::Index p = root.rows();
  for_ordered_blocks<Sums>(
      count, std::max(kPosesPerBlock, (count + kMaxBlocks - 1) / kMaxBlocks),
      [&](int begin, int end) {
        Sums sums;
        for (int first = begin, last = first; first < end; first = last) {
          // As many poses at once as stay in cache.
          const int top = rows.first[first];
          while (last < end && (last == first || rows.first[last] - top < kRowsAtOnce)) ++last;
          Eigen::MatrixXd blocks((rows.first[last] - top) * size, p + 1);
          for (int k = top; k < rows.first[last]; ++k) {
            auto block = blocks.middleRows((k - top) * size, size);
            at.block(rows.row[k], block);
            if (const double weight = weights[rows.row[k]]; weight != 1) block *= std::sqrt(weight);
          }
          const Eigen::MatrixXd shown = blocks.leftCols(p) * root;
          for (int pose = first; pose < last; ++pose) {
            const int begin_own = (rows.first[pose] - top) * size;
            const int own = (rows.first[pose + 1] - rows.first[pose]) * size;
            const auto of_pose = shown.middleRows(begin_own, own);
            add(sums, influence_of_pose(of_pose, blocks.col(p).segment(begin_own, own)), of_pose);
          }
        }
        return sums;
      },
      join);
}

}  // namespace armtrue
