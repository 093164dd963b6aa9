#include "calibration/fold.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

// From this many on, most of the unknowns are knots of curves, and few of them move a row.
constexpr int kManyUnknowns = 150;
constexpr int kRowsPerFactor = 256;  // folded at once; small enough to stay in cache

// Fixed by the number of rows alone, so that the result does not depend on the machine; at most
// 256 blocks, whose results wait for each other in memory.
int rows_per_block(int rows) { return std::max(kRowsPerBlock, (rows + 255) / 256); }

// The triangle whose products are these (upper half); directions that are rounding alone are left
// out.
Eigen::MatrixXd triangle_of(const Eigen::MatrixXd& upper) {
  const Eigen::MatrixXd products = upper.selfadjointView<Eigen::Upper>();
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

Eigen::MatrixXd Fold::triangle() const {
  return factor.size() > 0 ? factor : triangle_of(products);
}

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Folds some rows of a campaign.
class BlockFolder {
 public:
  BlockFolder(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
              FoldBy by)
      : at_(at),
        model_(model),
        law_(law),
        rows_(kRowsPerFactor * model.row_size(), model.unknowns() + 1),
        folded_(zero_fold(model, law, by)),
        slopes_(folded_.bend.rows(), kRowsPerFactor),
        is_sparse_(by == FoldBy::normal_equations && model.unknowns() > kManyUnknowns) {}

  static Fold zero_fold(const ObservationModel& model, const ReadingLaw& law, FoldBy by) {
    const int p = model.unknowns();
    Fold zero;
    (by == FoldBy::qr ? zero.factor : zero.products) = Eigen::MatrixXd::Zero(p + 1, p + 1);
    if (by == FoldBy::normal_equations && law.degrees_of_freedom > 0)
      zero.bend = Eigen::MatrixXd::Zero(p, p);
    return zero;
  }

  Fold of(int begin, int end) {
    for (int row = begin; row < end; ++row) {
      add(row);
      if (filled_ == kRowsPerFactor || row + 1 == end) empty();
    }
    return std::move(folded_);
  }

 private:
  void add(int row) {
    const int size = model_.row_size();
    auto out = rows_.middleRows(filled_ * size, size);
    at_.block(row, out);
    const double squared_norm = out.rightCols<1>().squaredNorm();
    const double variance = law_.variance_of(row), dof = law_.degrees_of_freedom;
    folded_.loss += law_.loss(squared_norm, size, variance);
    if (dof > 0) out *= std::sqrt(law_.weight(squared_norm, size, variance));
    // w' = -w^2 / ((nu + d) v), and the rows hold sqrt(w) J and sqrt(w) r.
    const double bending = dof > 0 ? std::sqrt(2 / ((dof + size) * variance)) : 0;
    if (is_sparse_) {
      add_sparse(out, bending);
      return;
    }
    if (folded_.bend.size() > 0)
      slopes_.col(filled_) =
          bending * (out.leftCols(out.cols() - 1).transpose() * out.rightCols<1>());
    ++filled_;
  }

  // A row that few of many unknowns move, as where curves have many knots: only the products of
  // columns that are not zero.
  void add_sparse(const Eigen::Ref<const Eigen::MatrixXd>& row, double bending) {
    nonzero_.clear();
    for (int k = 0; k < row.cols(); ++k)
      if ((row.col(k).array() != 0).any()) nonzero_.push_back(k);
    const auto count = static_cast<Eigen::Index>(nonzero_.size());
    const RowMajor dense = row(Eigen::all, nonzero_);
    const int last = static_cast<int>(row.cols()) - 1;
    for (Eigen::Index j = 0; j < count; ++j) {
      const int column = nonzero_[static_cast<size_t>(j)];
      products_ = dense.leftCols(j + 1).transpose().lazyProduct(dense.col(j));
      scatter(folded_.products.col(column));
      if (column < last || folded_.bend.size() == 0) continue;
      // The products with the residual are the slopes.
      const Eigen::VectorXd slope = bending * products_.head(j);
      for (Eigen::Index k = 0; k < j; ++k) {
        products_ = slope[k] * slope.head(k + 1);
        scatter(folded_.bend.col(nonzero_[static_cast<size_t>(k)]));
      }
    }
  }

  // Adds the products to the rows of a column that are not zero.
  void scatter(Eigen::Ref<Eigen::VectorXd> column) const {
    for (Eigen::Index i = 0; i < products_.size(); ++i)
      column[nonzero_[static_cast<size_t>(i)]] += products_[i];
  }

  // Takes the rows into the sums.
  void empty() {
    if (is_sparse_) return;
    const auto rows = rows_.topRows(filled_ * model_.row_size());
    if (folded_.factor.size() > 0)
      fold_into(folded_.factor, rows);
    else
      folded_.products.selfadjointView<Eigen::Upper>().rankUpdate(rows.transpose());
    if (folded_.bend.size() > 0)
      folded_.bend.selfadjointView<Eigen::Upper>().rankUpdate(slopes_.leftCols(filled_));
    filled_ = 0;
  }

  const ObservationModel::At& at_;
  const ObservationModel& model_;
  const ReadingLaw& law_;
  Eigen::MatrixXd rows_;  // weighted
  int filled_ = 0;
  Fold folded_;
  Eigen::MatrixXd slopes_;  // a column for each row, whose products add up to `bend`
  bool is_sparse_;
  std::vector<int> nonzero_;
  Eigen::VectorXd products_;
};

}  // namespace

Fold fold(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
          FoldBy by) {
  Fold total = BlockFolder::zero_fold(model, law, by);
  for_ordered_blocks<Fold>(
      model.rows(), rows_per_block(model.rows()),
      [&](int begin, int end) { return BlockFolder(at, model, law, by).of(begin, end); },
      [&](const Fold& block) {
        total.loss += block.loss;
        if (by == FoldBy::qr) {
          fold_into(total.factor, block.factor);
          return;
        }
        total.products += block.products;
        if (total.bend.size() > 0) total.bend += block.bend;
      });
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
