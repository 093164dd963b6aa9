#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/calibration/observation.h"

namespace armtrue {

/// Student's t as the law of the readings: with few degrees of freedom a blunder hardly counts,
/// with infinitely many it is least squares. Chosen because its weights fall off smoothly: nothing
/// is thrown away, and structure that the model still lacks only lowers the weight of its worst
/// rows. Source: Lange, Little, Taylor, "Robust statistical modeling using the t distribution",
/// 1989.
///
/// A blunder strikes one reading; what the model lacks strikes every reading of a pose. Where all
/// of them are off, each is only judged against the others: `variance` is above 1 there.
struct ReadingLaw {
  double degrees_of_freedom = 0;   ///< 0: Gaussian
  std::vector<double> variance{};  ///< of each row, in units of the campaign's; empty: 1

  bool operator==(const ReadingLaw&) const = default;
  double variance_of(int row) const { return variance.empty() ? 1.0 : variance[row]; }
  /// Weight of a row whose whitened residual has this squared norm; near 1 on average.
  double weight(double squared_norm, int dimension, double row_variance = 1.0) const;
  /// Twice the negative log-likelihood of the row, in units of its variance and up to a constant;
  /// its derivative is the weight.
  double loss(double squared_norm, int dimension, double row_variance = 1.0) const;
};

/// Variances for ReadingLaw from the squared norms of the whitened residuals: of a row, the
/// geometric mean over the other readings of its pose (from the same anchor), and at least 1. The
/// arithmetic mean would let two blunders in a pose hide each other; the best of the others would
/// take the target that the lacking effect moves most for a blunder.
std::vector<double> pose_variances(const Campaign& campaign, const std::vector<double>& norms,
                                   int dimension);

/// All rows of a campaign folded into an upper triangular factor: `factor` is (p+1) x (p+1), its
/// first p columns the R of the weighted Jacobian, its last the residual in the same basis.
struct Fold {
  Eigen::MatrixXd factor;
  double loss = 0;
};

/// How rows are folded: by orthogonal transformations (TSQR), or by sums of products, several times
/// faster with hundreds of unknowns, but a direction of relative size e is known to 1e-16 / e^2
/// only. For steps of a search, not for statistics.
enum class FoldBy { qr, normal_equations };

/// Streams the rows in blocks over the threads of the machine and folds each, so that memory does
/// not grow with the number of rows. Blocks are fixed and joined in order: the result does not
/// depend on the number of threads.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by = FoldBy::qr);

/// Only the loss.
double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law);

/// Squared norms of the whitened residuals of each row: position, orientation.
std::vector<Eigen::Vector2d> squared_norms(const ObservationModel::At& at,
                                           const ObservationModel& model);

}  // namespace armtrue
