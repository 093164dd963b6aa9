#include "calibration/fold.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

constexpr int kRowsPerFactor = 256;  // folded at once; small enough to stay in cache

// Fixed by the number of rows alone, so that the result does not depend on the machine; at most
// 256 blocks, whose results wait for each other in memory.
int rows_per_block(int rows) { return std::max(kRowsPerBlock, (rows + 255) / 256); }

// The triangle whose products are these; directions that are rounding alone are left out.
Eigen::MatrixXd triangle_of(const Eigen::MatrixXd& products) {
  const Eigen::VectorXd unit = products.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(unit.asDiagonal() * products * unit.asDiagonal());
  const Eigen::MatrixXd pivoted =
      ldlt.transpositionsP() * Eigen::MatrixXd(unit.cwiseInverse().asDiagonal());
  const Eigen::MatrixXd root = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                               Eigen::MatrixXd(ldlt.matrixU() * pivoted);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(root);
  return qr.matrixQR().triangularView<Eigen::Upper>();
}

// Folds `rows` (m x n) into the triangle `factor` (n x n) above it.
void fold_into(Eigen::MatrixXd& factor, const Eigen::Ref<const Eigen::MatrixXd>& rows) {
  const Eigen::Index n = factor.cols();
  Eigen::MatrixXd stacked(n + rows.rows(), n);
  stacked << factor, rows;
  Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(stacked);
  factor = stacked.topRows(n).triangularView<Eigen::Upper>();
}

Eigen::Vector2d row_norms(const ObservationModel::At& at, const ObservationModel& model, int row) {
  const Eigen::Matrix<double, 6, 1> r = at.residual(row);
  const ReadingSigma sigma = model.row_sigma(row);
  return {r.head<3>().squaredNorm() / (sigma.position * sigma.position),
          r.tail<3>().squaredNorm() / (sigma.orientation * sigma.orientation)};
}

}  // namespace

Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by) {
  const auto fold_in = [by](Eigen::MatrixXd& factor, const Eigen::Ref<const Eigen::MatrixXd>& m) {
    if (by == FoldBy::qr)
      fold_into(factor, m);
    else
      factor.selfadjointView<Eigen::Upper>().rankUpdate(m.transpose());
  };
  const int columns = model.unknowns() + 1, size = model.row_size();
  const auto fold_block = [&](int begin, int end) {
    Fold block{Eigen::MatrixXd::Zero(columns, columns), 0.0};
    Eigen::MatrixXd rows(kRowsPerFactor * size, columns);
    int filled = 0;
    for (int row = begin; row < end; ++row) {
      auto out = rows.middleRows(filled * size, size);
      at.block(row, out);
      const double squared_norm = out.rightCols<1>().squaredNorm();
      const double variance = law.variance_of(row);
      block.loss += law.loss(squared_norm, size, variance);
      if (law.degrees_of_freedom > 0) out *= std::sqrt(law.weight(squared_norm, size, variance));
      if (++filled == kRowsPerFactor || row + 1 == end) {
        fold_in(block.factor, rows.topRows(filled * size));
        filled = 0;
      }
    }
    return block;
  };
  Fold total{Eigen::MatrixXd::Zero(columns, columns), 0.0};
  for_ordered_blocks<Fold>(model.rows(), rows_per_block(model.rows()), fold_block,
                           [&](const Fold& block) {
                             total.loss += block.loss;
                             if (by == FoldBy::qr)
                               fold_into(total.factor, block.factor);
                             else
                               total.factor += block.factor;
                           });
  if (by == FoldBy::normal_equations)
    total.factor = triangle_of(total.factor.selfadjointView<Eigen::Upper>());
  return total;
}

double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law) {
  double total = 0;
  for_ordered_blocks<double>(
      model.rows(), rows_per_block(model.rows()),
      [&](int begin, int end) {
        double loss = 0;
        for (int row = begin; row < end; ++row)
          loss += law.loss(row_norms(at, model, row).sum(), model.row_size(), law.variance_of(row));
        return loss;
      },
      [&](double loss) { total += loss; });
  return total;
}

std::vector<Eigen::Vector2d> squared_norms(const ObservationModel::At& at,
                                           const ObservationModel& model) {
  std::vector<Eigen::Vector2d> norms(model.rows());
  for_ordered_blocks<int>(
      model.rows(), rows_per_block(model.rows()),
      [&](int begin, int end) {
        for (int row = begin; row < end; ++row) norms[row] = row_norms(at, model, row);
        return 0;
      },
      [](int) {});
  return norms;
}

}  // namespace armtrue
