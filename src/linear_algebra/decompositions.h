#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "linear_algebra/kernels.h"

/// The decompositions that the house uses, of dense matrices of doubles. They are instantiated
/// once, in decompositions.cc; a file that includes this header instead of Eigen's compiles none of
/// them, if it gives them a matrix or a vector: an expression, or a part of a matrix, makes Eigen
/// compile most of a decomposition for its type, which takes seconds.
#define ARMTRUE_DECOMPOSITIONS(instantiate)                                                        \
  instantiate class HouseholderQR<MatrixXd>;                                                       \
  instantiate class ColPivHouseholderQR<MatrixXd>;                                                 \
  instantiate class CompleteOrthogonalDecomposition<MatrixXd>;                                     \
  instantiate class SelfAdjointEigenSolver<MatrixXd>;                                              \
  instantiate class JacobiSVD<MatrixXd>;                                                           \
  instantiate class LDLT<MatrixXd>;                                                                \
  instantiate class LLT<MatrixXd>;                                                                 \
  /* Members that are templates themselves, which the lines above leave out. */                    \
  instantiate SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(         \
      const EigenBase<MatrixXd>&, int);                                                            \
  instantiate LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);                 \
  instantiate LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);                   \
  instantiate void HouseholderQR<Ref<MatrixXd>>::computeInPlace();                                 \
  instantiate void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;         \
  instantiate void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;   \
  instantiate void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const VectorXd&,         \
                                                                          VectorXd&) const;        \
  instantiate void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;   \
  instantiate void LDLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const; \
  instantiate void LDLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const; \
  instantiate void LLT<MatrixXd>::_solve_impl_transposed<true>(const VectorXd&, VectorXd&) const;  \
  instantiate void LLT<MatrixXd>::_solve_impl_transposed<true>(const MatrixXd&, MatrixXd&) const;  \
  /* What the solvers call for an argument of any type. */                                         \
  instantiate void internal::tridiagonalization_inplace(MatrixXd&, VectorXd&, VectorXd&,           \
                                                        VectorXd&, bool);                          \
  instantiate Matrix4d umeyama(const MatrixBase<Matrix3Xd>&, const MatrixBase<Matrix3Xd>&, bool);

namespace Eigen {

ARMTRUE_DECOMPOSITIONS(extern template)

}  // namespace Eigen

namespace armtrue {

/// Q of a decomposition, as householderQ() gives it.
using Reflections = Eigen::HouseholderSequence<Eigen::MatrixXd, Eigen::VectorXd>;

/// Q times a matrix or a vector; Eigen's operator compiles for seconds in each file.
Eigen::MatrixXd product(const Reflections& q, const Eigen::MatrixXd& columns);
Eigen::VectorXd product(const Reflections& q, const Eigen::VectorXd& column);

/// The first `count` columns of Q.
Eigen::MatrixXd first_columns(const Reflections& q, Eigen::Index count);

Eigen::MatrixXd identity(Eigen::Index size);

}  // namespace armtrue
