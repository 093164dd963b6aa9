#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace armtrue {

/// What observability asks of the eigenvalues of a symmetric positive definite matrix.
struct Spectrum {
  double smallest = 0, largest = 0;
  double mean_log = 0;              ///< mean of their logarithms
  double sum_of_inverse_roots = 0;  ///< sum of 1 / sqrt
};

/// The spectrum of a matrix [D B; B^T C] whose part D is block-diagonal: each of the `blocks` (rows
/// of the matrix) meets no other, and all other rows are the border, C. With D diagonalised,
///     A - s I is positive definite where D - s I and C - s I - B^T (D - s I)^-1 B are,
/// so bisection finds the ends of the spectrum, and the determinant is that of both. With u = ln t,
///     tr A^-1/2 = 1 / pi integral of sqrt(t) tr (A + t I)^-1 du,
/// where the trapezoidal rule converges exponentially (Hale, Higham, Trefethen, "Computing A^alpha,
/// log(A), and related matrix functions by contour integrals", 2008). Cost is proportional to the
/// number of rows times the square of the border. Nothing if the matrix is not positive definite,
/// or its smallest eigenvalue is below `least_share` of the largest.
std::optional<Spectrum> bordered_spectrum(const Eigen::MatrixXd& symmetric,
                                          const std::vector<std::vector<Eigen::Index>>& blocks,
                                          double least_share);

}  // namespace armtrue
