#include "linear_algebra/sparse_cholesky.h"

#include <Eigen/SparseCholesky>
#include <cmath>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kMinSize = 256;   // a smaller dense one is as fast
constexpr Eigen::Index kMaxShareOf = 4;  // of the numbers are not zero: a quarter
// Of columns of unit length; a smaller one has few right digits. Of blocks scaled to unit matrices
// what is weak is common to several of them.
constexpr double kMinPivot = 1e-5, kMinPivotOfBlocks = 1e-7;
constexpr double kSmallest = 1e-14;  // eigenvalue of the largest, see inverse_root()
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

// V Lambda^-1/2 of each block of `scaled`, by the rows of the unknowns.
SparseColumns roots_of_blocks(const SparseColumns& scaled, const SparseCholesky::Blocks& blocks) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Index rank = 0;
  for (size_t b = 0; b < blocks.size(); ++b) {
    const Eigen::Index size = std::ssize(blocks[b]);
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size, size);
    for (Eigen::Index k = 0; k < size; ++k)
      for (Eigen::Index i = k; i < size; ++i)
        block(i, k) = scaled.coeff(blocks[b][i], blocks[b][k]);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(block);
    const Eigen::VectorXd& values = eigen.eigenvalues();  // smallest first
    for (Eigen::Index k = 0; k < size; ++k) {
      if (!(values[k] > kSmallest * values[size - 1])) continue;
      for (Eigen::Index i = 0; i < size; ++i)
        entries.emplace_back(blocks[b][i], rank, eigen.eigenvectors()(i, k) / std::sqrt(values[k]));
      ++rank;
    }
  }
  SparseColumns roots(scaled.cols(), rank);
  roots.setFromTriplets(entries.begin(), entries.end());
  return roots;
}

}  // namespace

bool is_sparse(const Eigen::MatrixXd& symmetric) {
  return symmetric.cols() >= kMinSize &&
         kMaxShareOf * (symmetric.array() != 0).count() < symmetric.size();
}

SparseCholesky::SparseCholesky(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& added,
                               const Blocks& blocks) {
  const Eigen::Index size = symmetric.cols();
  Eigen::VectorXd diagonal = symmetric.diagonal();
  if (added.size() > 0) diagonal += added;
  const Eigen::VectorXd unit = diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  std::vector<Eigen::Triplet<double>> lower;
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto enter = [&](Eigen::Index row, double value) {
      lower.emplace_back(row, column, unit[row] * value * unit[column]);
    };
    enter(column, diagonal[column]);
    for (Eigen::Index row = column + 1; row < size; ++row)
      if (symmetric(row, column) != 0) enter(row, symmetric(row, column));
  }
  SparseColumns scaled(size, size);
  scaled.setFromTriplets(lower.begin(), lower.end());
  basis_ = unit.asDiagonal();
  factorise(scaled);
  is_clear_ = smallest_pivot_ >= kMinPivot;
  if (is_clear_ || blocks.empty()) return;
  const SparseColumns roots = roots_of_blocks(scaled, blocks);
  const SparseColumns whole = scaled.selfadjointView<Eigen::Lower>();
  basis_ = basis_ * SparseRows(roots);
  factorise(roots.transpose() * whole * roots);
  is_clear_ = smallest_pivot_ >= kMinPivotOfBlocks;
}

void SparseCholesky::factorise(const SparseColumns& lower) {
  const Eigen::SimplicialLLT<SparseColumns, Eigen::Lower, Eigen::AMDOrdering<int>> llt(lower);
  succeeded_ = llt.info() == Eigen::Success;
  smallest_pivot_ = 0;
  if (!succeeded_) return;
  factor_ = llt.matrixL();
  place_ = llt.permutationP().indices();
  if (factor_.cols() > 0) smallest_pivot_ = factor_.diagonal().minCoeff();
}

// With P T^T A T P^T = F F^T the root is T P^T F^-T; row k of P^T F^-T is a column of F^-1.
SparseRows SparseCholesky::inverse_root() const {
  const Eigen::Index size = factor_.cols();
  Eigen::VectorXd work = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index row = 0; row < size; ++row)
    invert_column(factor_, place_[row], work,
                  [&](Eigen::Index k, double value) { entries.emplace_back(row, k, value); });
  SparseRows root(size, size);
  root.setFromTriplets(entries.begin(), entries.end());
  return basis_ * root;
}

double SparseCholesky::variance(Eigen::Index unknown) const {
  Eigen::VectorXd work = Eigen::VectorXd::Zero(factor_.cols()), row = work;
  for (SparseRows::InnerIterator entry(basis_, unknown); entry; ++entry)
    invert_column(factor_, place_[entry.col()], work,
                  [&](Eigen::Index k, double value) { row[k] += entry.value() * value; });
  return row.squaredNorm();
}

}  // namespace armtrue
