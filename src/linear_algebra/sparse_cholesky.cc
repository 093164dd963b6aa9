#include "linear_algebra/sparse_cholesky.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <vector>

namespace armtrue {
namespace {

constexpr Eigen::Index kMinSize = 256;     // a smaller dense one is as fast
constexpr Eigen::Index kMaxShareOf = 4;    // of the numbers are not zero: a quarter
using SparseColumns = Eigen::SparseMatrix<double>;

// Hands the numbers of column `column` of the inverse of the lower triangle to take(row, value). A
// column is not zero only on its way to the root of the elimination tree, whose parent is the first
// number below the diagonal. `work`: zeros.
template <typename Take>
void invert_column(const SparseColumns& lower, Eigen::Index column, Eigen::VectorXd& work,
                   const Take& take) {
  work[column] = 1;
  for (Eigen::Index k = column; k >= 0;) {
    SparseColumns::InnerIterator entry(lower, k);  // the diagonal first
    const double value = work[k] / entry.value();
    work[k] = 0;
    take(k, value);
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

SparseCholesky::SparseCholesky(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& added) {
  const Eigen::Index size = symmetric.cols();
  Eigen::VectorXd diagonal = symmetric.diagonal();
  if (added.size() > 0) diagonal += added;
  unit_ = diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  std::vector<Eigen::Triplet<double>> lower;
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto enter = [&](Eigen::Index row, double value) {
      lower.emplace_back(static_cast<int>(row), static_cast<int>(column),
                         unit_[row] * value * unit_[column]);
    };
    enter(column, diagonal[column]);
    for (Eigen::Index row = column + 1; row < size; ++row)
      if (symmetric(row, column) != 0) enter(row, symmetric(row, column));
  }
  SparseColumns scaled(size, size);
  scaled.setFromTriplets(lower.begin(), lower.end());
  const Eigen::SimplicialLLT<SparseColumns, Eigen::Lower, Eigen::AMDOrdering<int>> llt(scaled);
  succeeded_ = llt.info() == Eigen::Success;
  if (!succeeded_) return;
  factor_ = llt.matrixL();
  place_ = llt.permutationP().indices();
  smallest_pivot_ = factor_.diagonal().minCoeff();
}

// With P A P^T = F F^T the root is P^T F^-T, whose row of an unknown is a column of F^-1.
SparseRows SparseCholesky::inverse_root() const {
  const Eigen::Index size = factor_.cols();
  Eigen::VectorXd work = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index unknown = 0; unknown < size; ++unknown)
    invert_column(factor_, place_[unknown], work, [&](Eigen::Index k, double value) {
      entries.emplace_back(static_cast<int>(unknown), static_cast<int>(k), value * unit_[unknown]);
    });
  SparseRows root(size, size);
  root.setFromTriplets(entries.begin(), entries.end());
  return root;
}

double SparseCholesky::variance(Eigen::Index unknown) const {
  Eigen::VectorXd work = Eigen::VectorXd::Zero(factor_.cols());
  double sum = 0;
  invert_column(factor_, place_[unknown], work,
                [&](Eigen::Index, double value) { sum += value * value; });
  return sum * unit_[unknown] * unit_[unknown];
}

}  // namespace armtrue
