#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/grouped_rows.h"
#include "armtrue/observation/session_models.h"
#include "linear_algebra/sparse_cholesky.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {

/// L with L L^T = information^-1, unknowns x rank: directions without information are left out.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& information);

/// The influence of one pose, with all its readings, on a fit, in coordinates of the unknowns in
/// which the information of the fit is the unit matrix: with A the rows of the pose in these
/// coordinates, r its residual and H = A A^T its leverage,
///     change = A^T (I - H)^-1 r.
struct PoseInfluence {
  Eigen::VectorXd change;  ///< the fit with the pose minus the fit without it, in one Newton step
  /// A^T times the eigenvectors of H with eigenvalue 1: directions that no other pose shows. They
  /// are left out of `change`.
  Eigen::MatrixXd alone;
};

/// `rows`: A, the whitened and weighted rows of the pose times inverse_root(). (I - H)^-1 r is the
/// residual that the pose would have if it took no part in the fit (CR3 of Bell, McCaffrey, "Bias
/// reduction in standard errors for linear regression with multi-stage samples", 2002).
PoseInfluence influence_of_pose(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                const Eigen::Ref<const Eigen::VectorXd>& residual);

/// (I - H)^-1/2 r: the residual of the pose, corrected so that its covariance is that of the
/// readings (CR2 of the same source). `rows`: of the pose, in an orthonormal basis of the fit.
Eigen::VectorXd leverage_corrected_residual(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                            const Eigen::Ref<const Eigen::VectorXd>& residual);

/// The sum of v v^T over sparse vectors v, stored for the coordinates that occur in them.
class SumOfSquares {
 public:
  SumOfSquares() = default;
  /// Reserves all of `count` coordinates.
  explicit SumOfSquares(Eigen::Index count);

  /// `vectors`: one a column, with the numbers of these coordinates.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& vectors,
           const std::vector<Eigen::Index>& coordinates);
  void add(const SumOfSquares& other);
  bool is_empty() const { return coordinate_at_.empty(); }
  /// The sum as a dense matrix of `count` coordinates.
  Eigen::MatrixXd dense(Eigen::Index count) const;

 private:
  // The places of coordinates, those of new ones behind the others.
  std::vector<Eigen::Index> places_of(const std::vector<Eigen::Index>& coordinates);

  std::vector<Eigen::Index> coordinate_at_, place_of_;  // kNowhere: of a coordinate without a place
  Eigen::MatrixXd squares_;                             // places x places
};

/// Sums over poses, from which the covariance is computed.
class InfluenceSums {
 public:
  InfluenceSums() = default;
  /// For the sums of all poses, with room for all of `count` coordinates.
  explicit InfluenceSums(Eigen::Index count)
      : sum_(Eigen::VectorXd::Zero(count)), squares_(count) {}

  /// `coordinates`: those of `pose`, of `count` altogether; the others are zero.
  void add(const PoseInfluence& pose, const std::vector<Eigen::Index>& coordinates,
           Eigen::Index count);
  void add(const PoseInfluence& pose);
  void add(const InfluenceSums& others);
  /// Cluster covariance by pose, with u_i the changes, n their number and k the mean psi
  /// derivative:
  ///     (n - 1) / (n k^2) sum_i (u_i - mean u) (u_i - mean u)^T + variance sum_i alone_i
  ///     alone_i^T.
  /// Directions that only one pose shows have no scatter between poses, so there the readings count
  /// as independent with `variance`.
  Eigen::MatrixXd covariance(double mean_psi_derivative, double variance) const;

 private:
  int poses_ = 0;
  Eigen::VectorXd sum_;
  SumOfSquares squares_, alone_;
};

/// Correction of the information for Student's t, whose weights w fall as residuals grow: with
/// psi(r) = w(r) r, the mean of psi' divided by the mean of w (Huber, "Robust statistics", 1981,
/// 7.6). Below 1; 1 if Gaussian.
double mean_psi_derivative(const std::vector<double>& weights, double degrees_of_freedom,
                           int dimension);

/// The rows of `count` of the poses, at equal steps; all if there are no more.
GroupedRows some_poses(const GroupedRows& all, int count);

/// rows * root, where most columns of `rows` may be zero.
Eigen::MatrixXd product_without_zeros(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                      const Eigen::MatrixXd& root);

/// The whitened and weighted rows of a pose, residuals last: unknowns + 1 columns. With weights w
/// the equations J x = r of replicates, which have the same J, are equivalent to one of weight W =
/// sum w and residual sum w r / W; the others, which have no derivatives, are left out.
Eigen::MatrixXd weighted_rows(const SessionModels::At& at, const std::vector<double>& weights,
                              std::span<const int> rows);

/// Number of poses in a block of for_each_pose().
int poses_per_block(int poses);

/// Calls `add(sums, influence, rows, coordinates)` for each pose, into a Sums for each block of
/// them, and hands those to `join` in the order of the poses. `root`: inverse_root() of the
/// information. `rows` as for influence_of_pose(), of these coordinates, which are all.
template <typename Sums, typename Add, typename Join>
void for_each_pose(const SessionModels::At& at, const std::vector<double>& weights,
                   const Eigen::MatrixXd& root, const GroupedRows& rows, const Add& add,
                   const Join& join) {
  constexpr int kRowsOfOnePart = 40;
  const int size = at.models().row_size();
  const Eigen::Index p = root.rows();
  std::vector<Eigen::Index> all(root.cols());
  std::iota(all.begin(), all.end(), 0);
  for_ordered_blocks<Sums>(
      rows.groups(), poses_per_block(rows.groups()),
      [&](int begin, int end) {
        Sums sums;
        std::vector<Eigen::MatrixXd> of_poses;
        for (int first = begin, last = first; first < end; first = last) {
          // As many poses at once as stay in cache.
          of_poses.clear();
          Eigen::Index equations = 0;
          for (; last < end && (last == first || equations < kRowsOfOnePart * size); ++last) {
            of_poses.push_back(weighted_rows(at, weights, rows.rows(last)));
            equations += of_poses.back().rows();
          }
          Eigen::MatrixXd blocks(equations, p + 1);
          for (Eigen::Index top = 0; const Eigen::MatrixXd& own : of_poses) {
            blocks.middleRows(top, own.rows()) = own;
            top += own.rows();
          }
          const Eigen::MatrixXd shown = product_without_zeros(blocks.leftCols(p), root);
          for (Eigen::Index top = 0; const Eigen::MatrixXd& own : of_poses) {
            const auto of_pose = shown.middleRows(top, own.rows());
            add(sums, influence_of_pose(of_pose, own.col(p)), of_pose, all);
            top += own.rows();
          }
        }
        return sums;
      },
      join);
}

/// The rows of a pose for influence_of_pose(), in the few coordinates in which they are not zero.
struct PoseRows {
  std::vector<Eigen::Index> coordinates;  // ascending
  Eigen::MatrixXd rows;
  Eigen::VectorXd residual;
};

/// For several groups: the rows of a root that belong to the unknowns of each group, without the
/// columns that are zero in all of them.
class RootsOfGroups {
 public:
  RootsOfGroups(const SessionModels& models, const SparseRows& root);

  /// The whitened derivatives of a row times the root, in the coordinates of its group.
  Eigen::MatrixXd of_row(const SessionModels::At& at, int row) const;
  PoseRows rows_of(const SessionModels::At& at, const std::vector<double>& weights,
                   const GroupedRows& rows, int pose) const;

 private:
  struct RootOfGroup {
    std::vector<Eigen::Index> coordinates;
    Eigen::MatrixXd root;
  };
  std::vector<RootOfGroup> groups_;
};

/// The poses in the order of the groups of their first rows, so that those of a block have many
/// coordinates in common.
std::vector<int> poses_by_group(const SessionModels::At& at, const GroupedRows& rows);

/// The same with a sparse root, in the order of poses_by_group().
template <typename Sums, typename Add, typename Join>
void for_each_pose(const SessionModels::At& at, const std::vector<double>& weights,
                   const SparseRows& root, const GroupedRows& rows, const Add& add,
                   const Join& join) {
  const RootsOfGroups roots(at.models(), root);
  const std::vector<int> order = poses_by_group(at, rows);
  for_ordered_blocks<Sums>(
      rows.groups(), poses_per_block(rows.groups()),
      [&](int begin, int end) {
        Sums sums;
        for (int k = begin; k < end; ++k) {
          const PoseRows pose = roots.rows_of(at, weights, rows, order[k]);
          add(sums, influence_of_pose(pose.rows, pose.residual), pose.rows, pose.coordinates);
        }
        return sums;
      },
      join);
}

}  // namespace armtrue
