#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Replaces a triangle R (n x n, upper) by that of the QR decomposition of R above `rows` (m x n),
/// which are used up. Householder's reflections leave the zeros of R alone: with Q^T Q = I,
///     Q [R_new; 0] = [R; rows].
/// (Golub and Van Loan, "Matrix Computations", 5.2: updates by rows, and products of reflections)
void fold_rows(Eigen::MatrixXd& triangle, Eigen::Ref<Eigen::MatrixXd> rows);

}  // namespace armtrue
