#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

/// The decompositions that the house uses, of dense matrices of doubles. They are instantiated
/// once, in decompositions.cc; a file that includes this header instead of Eigen's compiles none of
/// them.
namespace Eigen {

extern template class HouseholderQR<MatrixXd>;
extern template class ColPivHouseholderQR<MatrixXd>;
extern template class CompleteOrthogonalDecomposition<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXd>;
extern template class JacobiSVD<MatrixXd>;
extern template class LDLT<MatrixXd>;
extern template class LLT<MatrixXd>;

}  // namespace Eigen
