#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "search/linearization.h"

namespace armtrue {

/// What adding columns to a fit is worth on poses that did not take part in it.
struct CrossValidation {
  double gain = 0;   ///< fall of the mean squared whitened residual, as a share of it
  double error = 0;  ///< standard error of the gain, over poses

  /// Leaves out a tenth of the poses at a time, in an order drawn from `seed`; linear in all
  /// unknowns. The columns are orthonormal and orthogonal to what is fitted.
  static CrossValidation of(const Linearization& fit, const Eigen::MatrixXd& added,
                            std::uint64_t seed);
  /// The same of an effect of the model beside all the others.
  static CrossValidation of_effect(const Linearization& fit, int effect, std::uint64_t seed);

  /// Of readings in blocks of `row_size` rows, each of one of the poses: `added` orthonormal beside
  /// the orthonormal `basis`, to which `residual` is orthogonal.
  static CrossValidation of(const std::vector<int>& pose, int row_size,
                            const Eigen::MatrixXd& basis, const Eigen::MatrixXd& added,
                            const Eigen::VectorXd& residual, std::uint64_t seed);
};

}  // namespace armtrue
