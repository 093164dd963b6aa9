#include "armtrue/observation/fold.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>

#include "linear_algebra/stacked_triangle.h"
#include "observation/block_folder.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

using Residual = Eigen::Matrix<double, 6, 1>;

// Calls take(row, residual).
template <typename Take>
void for_each_residual(const ObservationModel::At& at, int begin, int end, const Take& take) {
  std::array<Residual, kRowsAtOnce> residuals;
  for (int first = begin; first < end; first += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, end - first);
    at.residuals(first, std::span(residuals).first(count));
    for (int k = 0; k < count; ++k) take(first + k, residuals[k]);
  }
}

// It depends on the number of rows alone, so that the result does not depend on the machine. At
// most 256 blocks: their results are held in memory together.
int rows_per_block(int rows) { return std::max(kRowsPerBlock, (rows + 255) / 256); }

// Such that a block has about rows_per_block() rows.
int predictions_per_block(const ObservationModel& model) {
  const long rows = std::max(1, model.rows()), predictions = model.rows_by_prediction().groups();
  return std::max(1,
                  static_cast<int>((rows_per_block(model.rows()) * predictions + rows - 1) / rows));
}

Eigen::Vector2d row_norms(const ObservationModel& model, int row, const Residual& r) {
  if (!model.campaign().whitening.empty()) {
    const NumbersOfRow white = model.whitened(row, r);
    return {white.head<3>().squaredNorm(), white.tail(white.size() - 3).squaredNorm()};
  }
  const ReadingSigma sigma = model.row_sigma(row);
  return {r.head<3>().squaredNorm() / (sigma.position * sigma.position),
          r.tail<3>().squaredNorm() / (sigma.orientation * sigma.orientation)};
}

}  // namespace

Eigen::MatrixXd Fold::information() const {
  const Eigen::Index p = std::max<Eigen::Index>({1, factor.cols(), products.cols()}) - 1;
  if (p == 0) return Eigen::MatrixXd(0, 0);
  if (factor.size() == 0) return products.topLeftCorner(p, p).selfadjointView<Eigen::Upper>();
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  return triangle.transpose() * triangle;
}

Eigen::VectorXd Fold::gradient() const {
  const Eigen::Index p = std::max(factor.cols(), products.cols()) - 1;
  if (factor.size() == 0) return products.col(p).head(p);
  return factor.topLeftCorner(p, p).transpose() * factor.col(p).head(p);
}

namespace {

Fold folded(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
            FoldBy by, const KeptDerivatives* kept) {
  Fold total = BlockFolder::zero_fold(model, law, by);
  for_ordered_blocks<Fold>(
      model.rows_by_prediction().groups(), predictions_per_block(model),
      [&](int begin, int end) { return BlockFolder(at, model, law, by, kept).of(begin, end); },
      [&](const Fold& block) {
        total.loss += block.loss;
        if (total.bend.size() > 0) total.bend += block.bend;
        if (by == FoldBy::normal_equations) {
          total.products += block.products;
          return;
        }
        Eigen::MatrixXd rows = block.factor;
        fold_rows(total.factor, rows);
      });
  return total;
}

}  // namespace

Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by) {
  return folded(at, model, law, by, nullptr);
}

Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          const KeptDerivatives& kept) {
  return folded(at, model, law, FoldBy::normal_equations, &kept);
}

Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          const KeptDerivatives& kept, const Fold& beside) {
  Fold total = beside;
  total.loss = 0;
  total.products.rightCols<1>().setZero();
  for_ordered_blocks<Fold>(
      model.rows_by_prediction().groups(), predictions_per_block(model),
      [&](int begin, int end) {
        return BlockFolder(at, model, law, FoldBy::normal_equations, &kept,
                           BlockFolder::What::slopes)
            .of(begin, end);
      },
      [&](const Fold& block) {
        total.loss += block.loss;
        total.products.rightCols<1>() += block.products;
      });
  return total;
}

KeptDerivatives keep_derivatives(const ObservationModel::At& at, const ObservationModel& model) {
  const int size = model.row_size(), unknowns = model.unknowns();
  const int predictions = model.rows_by_prediction().groups();
  // Estimated: each row depends on as many unknowns as the first one.
  const auto reserve = [&](int rows, size_t of_row, KeptDerivatives& kept) {
    const size_t count = rows * of_row;
    kept.first.reserve(rows + 1);
    kept.column.reserve(count);
    kept.value.reserve(count * size);
  };
  KeptDerivatives all;
  all.sigma = model.sigma();
  all.first.push_back(0);
  for_ordered_blocks<KeptDerivatives>(
      predictions, predictions_per_block(model),
      [&](int begin, int end) {
        KeptDerivatives block;
        Eigen::MatrixXd rows(kRowsAtOnce * size, unknowns + 1);
        std::vector<int> nonzero;
        for (int k = begin; k < end; ++k) {
          const int place = (k - begin) % kRowsAtOnce;
          if (place == 0) at.blocks_of_predictions(k, std::min(kRowsAtOnce, end - k), rows);
          const auto row = rows.middleRows(place * size, size);
          find_nonzero(row.leftCols(unknowns), nonzero);
          if (k == begin) reserve(end - begin, nonzero.size(), block);
          for (int column : nonzero)
            block.value.insert(block.value.end(), row.col(column).begin(), row.col(column).end());
          block.column.insert(block.column.end(), nonzero.begin(), nonzero.end());
          block.first.push_back(block.column.size());
        }
        return block;
      },
      [&](const KeptDerivatives& block) {
        if (all.column.empty()) reserve(predictions, block.column.size() / block.first.size(), all);
        for (size_t end : block.first) all.first.push_back(all.column.size() + end);
        all.column.insert(all.column.end(), block.column.begin(), block.column.end());
        all.value.insert(all.value.end(), block.value.begin(), block.value.end());
      });
  return all;
}

double total_loss(const ObservationModel::At& at, const ObservationModel& model,
                  const ReadingLaw& law) {
  double total = 0;
  for_ordered_blocks<double>(
      model.rows(), rows_per_block(model.rows()),
      [&](int begin, int end) {
        double loss = 0;
        for_each_residual(at, begin, end, [&](int row, const Residual& r) {
          loss += law.loss(row_norms(model, row, r).sum(), model.row_size(), law.variance_of(row));
        });
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
        for_each_residual(at, begin, end, [&](int row, const Residual& r) {
          norms[row] = row_norms(model, row, r);
        });
        return 0;
      },
      [](int) {});
  return norms;
}

}  // namespace armtrue
