#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/observation/fold_by.h"
#include "armtrue/observation/observation.h"
#include "armtrue/observation/reading_law.h"

namespace armtrue {

/// All rows of a campaign reduced to (p+1) x (p+1) numbers, with J the whitened Jacobian (p
/// columns), r the whitened residual and W the weights of the rows.
struct Fold {
  /// By QR: upper triangular, factor^T factor = [J r]^T W [J r].
  Eigen::MatrixXd factor{};
  /// By normal equations: [J r]^T W [J r], upper half.
  Eigen::MatrixXd products{};
  /// Under Student's t: what the changing weights take off the second derivative of loss / 2, p x
  /// p, upper half. With s_i = |r_i|^2 and w_i = loss'(s_i),
  ///     H = J^T W J - bend,   bend = sum_i -2 w'(s_i) (J_i^T r_i)(J_i^T r_i)^T,
  /// for a linear model. Steps by H converge quadratically, by J^T W J only linearly.
  Eigen::MatrixXd bend{};
  double loss = 0;  ///< sum of ReadingLaw::loss over the rows

  /// J^T W J: p x p.
  Eigen::MatrixXd information() const;

  /// J^T W r: p.
  Eigen::VectorXd gradient() const;
};

/// Folds the rows in blocks over the threads of the machine, so that memory does not grow with the
/// number of rows. Replicates of a prediction have one row of derivatives. Blocks are fixed and
/// joined in order: the result does not depend on the number of threads.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by = FoldBy::qr);

/// The whitened derivatives of all predictions at one x, without their zeros. Near that x the model
/// is linear: a fold takes the derivatives from here and computes only the residuals again.
struct KeptDerivatives {
  ReadingSigma sigma;         ///< used to whiten them
  std::vector<size_t> first;  ///< by prediction: index of its first column; and one past the last
  std::vector<int> column;    ///< the unknown of each column
  std::vector<double> value;  ///< row_size numbers for each column
};

KeptDerivatives keep_derivatives(const ObservationModel::At& at, const ObservationModel& model);

/// Folds by normal equations, with the derivatives that were kept in place of those at `at`.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          const KeptDerivatives& kept);

/// Gradient and loss at `at`, with J^T W J and `bend` of `beside`: a fold by normal equations at a
/// near x under the same law. It takes a small part of the time of a whole fold.
Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          const KeptDerivatives& kept, const Fold& beside);

/// Fold::loss, without derivatives.
double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law);

/// Squared norms of the whitened residuals of each row: position, orientation.
std::vector<Eigen::Vector2d> squared_norms(const ObservationModel::At& at,
                                           const ObservationModel& model);

}  // namespace armtrue
