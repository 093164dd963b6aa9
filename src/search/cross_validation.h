#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "search/linearization.h"
#include "search/projection.h"

namespace armtrue {

/// Gain of adding columns to a fit, on poses that the fit did not use.
struct CrossValidation {
  double gain = 0;   ///< fall of the mean squared whitened residual, as a share of it
  double error = 0;  ///< standard error of the gain, over poses

  /// Leaves out a tenth of the poses at a time, in an order drawn from `seed`; linear in all
  /// unknowns. The columns are orthonormal and orthogonal to the fitted columns.
  static CrossValidation of(const Linearization& fit, const Directions& added, std::uint64_t seed);
  /// The same for an effect of the model beside all the others.
  static CrossValidation of_effect(const Linearization& fit, int effect, std::uint64_t seed);

  /// The same for readings in blocks of `row_size` rows, each from one pose. The columns of `basis`
  /// and `added` are orthonormal together; `residual` is orthogonal to `basis`.
  static CrossValidation of(const std::vector<int>& pose, int row_size,
                            const Eigen::MatrixXd& basis, const Eigen::MatrixXd& added,
                            const Eigen::VectorXd& residual, std::uint64_t seed);
};

/// Whether the poses left out speak for one of two models at a level of one in a thousand. A pose
/// has one difference of squared errors, positive where that model predicts it better. The test is
/// Vuong's (Econometrica 57, 1989) for models that do not contain each other: the mean in units of
/// its standard error. The sum alone would ignore that few poses may make it.
bool is_clearly_better(const Eigen::VectorXd& differences);

}  // namespace armtrue
