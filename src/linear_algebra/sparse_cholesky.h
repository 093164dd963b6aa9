#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace armtrue {

/// A matrix of which a row has few numbers that are not zero.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Whether few enough numbers of a symmetric matrix are not zero that SparseCholesky pays.
bool is_sparse(const Eigen::MatrixXd& symmetric);

/// Cholesky's factor of the information of unknowns of which most meet few others, such as the
/// bases of sessions and the places of targets, which meet only what is common to all. Rows and
/// columns are scaled to a diagonal of 1 and ordered so that the factor stays sparse (approximate
/// minimum degree: Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", 1996).
class SparseCholesky {
 public:
  /// `added`: to the diagonal; empty: nothing.
  explicit SparseCholesky(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& added = {});

  /// False if the matrix is not positive definite.
  bool succeeded() const { return succeeded_; }
  /// Smallest pivot of the scaled factor: what the columns before leave of a column of length 1.
  double smallest_pivot() const { return smallest_pivot_; }
  /// L with L L^T = inverse of the matrix, by the rows of the unknowns.
  SparseRows inverse_root() const;
  /// An element of the diagonal of the inverse.
  double variance(Eigen::Index unknown) const;

 private:
  bool succeeded_ = false;
  double smallest_pivot_ = 0;
  // The scaled matrix is P^T F F^T P, with column place_[k] of F that of unknown k.
  Eigen::SparseMatrix<double> factor_;
  Eigen::VectorXi place_;
  Eigen::VectorXd unit_;
};

}  // namespace armtrue
