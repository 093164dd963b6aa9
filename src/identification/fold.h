#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/identification/observation.h"

namespace armtrue {

/// Student's t as the law of the readings: with few degrees of freedom a blunder hardly counts,
/// with infinitely many it is least squares. Chosen because its weights fall off smoothly: nothing
/// is thrown away, and structure that the model still lacks only lowers the weight of its worst
/// rows. Source: Lange, Little, Taylor, "Robust statistical modeling using the t distribution",
/// 1989.
struct ReadingLaw {
  double degrees_of_freedom = 0;  ///< 0: Gaussian

  /// Weight of a row whose whitened residual has this squared norm; 1 on average.
  double weight(double squared_norm, int dimension) const;
  /// Twice the negative log-likelihood of the row, up to a constant; its derivative is the weight.
  double loss(double squared_norm, int dimension) const;
};

/// All rows of a campaign folded into an upper triangular factor: `factor` is (p+1) x (p+1), its
/// first p columns the R of the weighted Jacobian, its last the residual in the same basis.
struct Fold {
  Eigen::MatrixXd factor;
  double loss = 0;
};

/// Streams the rows in blocks over two threads at most and folds each by QR (TSQR), so that memory
/// does not grow with the number of rows. Blocks are fixed and joined in order: the result does not
/// depend on the number of threads.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law);

/// Only the loss.
double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law);

/// Squared norms of the whitened residuals of each row: position, orientation.
std::vector<Eigen::Vector2d> squared_norms(const ObservationModel::At& at,
                                           const ObservationModel& model);

}  // namespace armtrue
