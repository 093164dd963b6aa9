#include "linear_algebra/decompositions.h"

namespace Eigen {

template class HouseholderQR<MatrixXd>;
template class ColPivHouseholderQR<MatrixXd>;
template class CompleteOrthogonalDecomposition<MatrixXd>;
template class SelfAdjointEigenSolver<MatrixXd>;
template class JacobiSVD<MatrixXd>;
template class LDLT<MatrixXd>;
template class LLT<MatrixXd>;

}  // namespace Eigen
