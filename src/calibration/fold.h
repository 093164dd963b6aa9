#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/calibration/fold_by.h"
#include "armtrue/calibration/observation.h"
#include "calibration/reading_law.h"

namespace armtrue {

/// All rows of a campaign folded into an upper triangular factor, (p+1) x (p+1), with
///     factor^T factor = [J r]^T W [J r],
/// J the whitened Jacobian (p columns), r the whitened residual, W the weights of the rows.
/// `loss` is the sum of ReadingLaw::loss over the rows.
struct Fold {
  Eigen::MatrixXd factor;
  double loss = 0;
};

/// Folds the rows in blocks over the threads of the machine, so that memory does not grow with the
/// number of rows. Blocks are fixed and joined in order: the result does not depend on the number
/// of threads.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by = FoldBy::qr);

/// Only the loss.
double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law);

/// Squared norms of the whitened residuals of each row: position, orientation.
std::vector<Eigen::Vector2d> squared_norms(const ObservationModel::At& at,
                                           const ObservationModel& model);

}  // namespace armtrue
