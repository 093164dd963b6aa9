#include "linear_algebra/sparse_cholesky.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

namespace armtrue {
namespace {

constexpr Eigen::Index kMinSize = 256;     // a smaller dense one is as fast
constexpr Eigen::Index kMaxShareOf = 4;    // of the numbers are not zero: a quarter
using SparseColumns = Eigen::SparseMatrix<double>;

// Adds column `column` of the inverse of the lower triangle to the rows `of_inverse`, whose order
// is that of the columns of the triangle. A column is not zero only on its way to the root of the
// elimination tree, whose parent is the first number below the diagonal.
void invert_column(const SparseColumns& lower, Eigen::Index column, Eigen::VectorXd& work,
                   std::vector<Eigen::Triplet<double>>& of_inverse, Eigen::Index row,
                   double scale) {
  work[column] = 1;
  for (Eigen::Index k = column; k >= 0;) {
    SparseColumns::InnerIterator entry(lower, k);  // the diagonal first
    const double value = work[k] / entry.value();
    work[k] = 0;
    of_inverse.emplace_back(static_cast<int>(row), static_cast<int>(k), value * scale);
    Eigen::Index parent = -1;
    for (++entry; entry; ++entry) {
      if (parent < 0) parent = entry.row();
      work[entry.row()] -= entry.value() * value;
    }
    k = parent;
  }
}

}  // namespace

bool is_sparse(const Eigen::MatrixXd& symmetric) {
  return symmetric.cols() >= kMinSize &&
         kMaxShareOf * (symmetric.array() != 0).count() < symmetric.size();
}

SparseCholesky::SparseCholesky(const Eigen::MatrixXd& symmetric) {
  const Eigen::Index size = symmetric.cols();
  const Eigen::VectorXd unit = symmetric.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  std::vector<Eigen::Triplet<double>> lower;
  for (Eigen::Index column = 0; column < size; ++column)
    for (Eigen::Index row = column; row < size; ++row)
      if (symmetric(row, column) != 0)
        lower.emplace_back(static_cast<int>(row), static_cast<int>(column),
                           unit[row] * symmetric(row, column) * unit[column]);
  SparseColumns scaled(size, size);
  scaled.setFromTriplets(lower.begin(), lower.end());
  const Eigen::SimplicialLLT<SparseColumns, Eigen::Lower, Eigen::AMDOrdering<int>> llt(scaled);
  succeeded_ = llt.info() == Eigen::Success;
  if (!succeeded_) return;
  const SparseColumns factor = llt.matrixL();
  smallest_pivot_ = factor.diagonal().minCoeff();
  // With P A P^T = F F^T the root is P^T F^-T, whose row of an unknown is a column of F^-1.
  Eigen::VectorXd work = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index unknown = 0; unknown < size; ++unknown)
    invert_column(factor, llt.permutationP().indices()[unknown], work, entries, unknown,
                  unit[unknown]);
  inverse_root_.resize(size, size);
  inverse_root_.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace armtrue
