#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace armtrue {

/// A matrix of which a row has few numbers that are not zero.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Whether few enough numbers of a symmetric matrix are not zero that SparseCholesky pays.
bool is_sparse(const Eigen::MatrixXd& symmetric);

/// Cholesky's factor of the information of unknowns of which most meet few others, such as the
/// bases of sessions and the places of targets, which meet only what is common to all. Rows and
/// columns are scaled to a diagonal of 1 and ordered so that the factor stays sparse (approximate
/// minimum degree: Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", 1996).
///
/// Where a pivot is small, as in a session of few readings, each of `blocks`, unknowns in
/// ascending order, is first turned to its own eigenvectors and scaled to the unit matrix, without
/// those whose eigenvalue is 1e-14 of its largest or less. Such a vector v of a block has v^T A v =
/// 0, and so A v = 0: what is left out meets nothing else, and the inverse is the pseudoinverse of
/// the scaled matrix.
class SparseCholesky {
 public:
  using Blocks = std::vector<std::vector<Eigen::Index>>;

  /// `added`: to the diagonal; empty: nothing.
  explicit SparseCholesky(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& added = {},
                          const Blocks& blocks = {});

  /// False if the matrix is not positive definite, but for the directions that are left out.
  bool succeeded() const { return succeeded_; }
  /// Whether no direction but those left out is so weak that rounding matters.
  bool is_clear() const { return is_clear_; }
  /// Smallest pivot of the scaled factor: what the columns before leave of a column of length 1.
  double smallest_pivot() const { return smallest_pivot_; }
  /// Number of directions that are not left out.
  Eigen::Index rank() const { return factor_.cols(); }
  /// L with L L^T = inverse of the matrix, by the rows of the unknowns: unknowns x rank.
  SparseRows inverse_root() const;
  /// An element of the diagonal of the inverse.
  double variance(Eigen::Index unknown) const;

 private:
  // `lower`: of the matrix in the basis.
  void factorise(const Eigen::SparseMatrix<double>& lower);

  bool succeeded_ = false, is_clear_ = false;
  double smallest_pivot_ = 0;
  // With T the basis, unknowns x rank, T^T A T = P^T F F^T P, with column place_[k] of F that of
  // column k of T.
  SparseRows basis_;
  Eigen::SparseMatrix<double> factor_;
  Eigen::VectorXi place_;
};

}  // namespace armtrue
