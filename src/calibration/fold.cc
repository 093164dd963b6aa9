#include "calibration/fold.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

// From this many on, most of the unknowns are knots of curves, and few of them move a row.
constexpr int kManyUnknowns = 150;
constexpr int kRowsPerFactor = 256;  // folded at once; small enough to stay in cache
constexpr int kRowsAtOnce = 32;      // evaluated at once, a divisor of the former
static_assert(kRowsPerFactor % kRowsAtOnce == 0);

using Residual = Eigen::Matrix<double, 6, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

// Calls take(row, residual).
template <typename Take>
void for_each_residual(const ObservationModel::At& at, int begin, int end, const Take& take) {
  std::array<Residual, kRowsAtOnce> residuals;
  for (int first = begin; first < end; first += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, end - first);
    at.residuals(first, std::span(residuals).first(static_cast<size_t>(count)));
    for (int k = 0; k < count; ++k) take(first + k, residuals[static_cast<size_t>(k)]);
  }
}

// Fixed by the number of rows alone, so that the result does not depend on the machine; at most
// 256 blocks, whose results wait for each other in memory.
int rows_per_block(int rows) { return std::max(kRowsPerBlock, (rows + 255) / 256); }

// Blocks of about as many rows.
int predictions_per_block(const ObservationModel& model) {
  const long rows = std::max(1, model.rows()), predictions = model.rows_by_prediction().groups();
  return static_cast<int>((rows_per_block(model.rows()) * predictions + rows - 1) / rows);
}

// Folds `rows` (m x n) into the triangle `factor` (n x n) above it.
void fold_into(Eigen::MatrixXd& factor, const Eigen::Ref<const Eigen::MatrixXd>& rows) {
  const Eigen::Index n = factor.cols();
  Eigen::MatrixXd stacked(n + rows.rows(), n);
  stacked << factor, rows;
  Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(stacked);
  factor = stacked.topRows(n).triangularView<Eigen::Upper>();
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

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The columns that are not zero, in ascending order.
void find_nonzero(const Eigen::Ref<const Eigen::MatrixXd>& row, std::vector<int>& nonzero) {
  nonzero.clear();
  for (int k = 0; k < row.cols(); ++k)
    if ((row.col(k).array() != 0).any()) nonzero.push_back(k);
}

enum class What { all, slopes };  // slopes: `products` is a column, what the last one is of all

// Folds the rows of some predictions.
class BlockFolder {
 public:
  // `kept`: null to take the derivatives at `at`. Slopes alone need them.
  BlockFolder(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
              FoldBy by, const KeptDerivatives* kept, What what = What::all)
      : at_(at),
        model_(model),
        law_(law),
        kept_(kept),
        what_(what),
        by_row_(what == What::slopes ||
                (by == FoldBy::normal_equations && model.unknowns() > kManyUnknowns)),
        rows_((by_row_ ? kRowsAtOnce : kRowsPerFactor) * model.row_size() + kPadding,
              model.unknowns() + 1),
        folded_(what == What::slopes ? Fold{.products = Eigen::VectorXd::Zero(rows_.cols())}
                                     : zero_fold(model, law, by)),
        slopes_(folded_.bend.rows(), by_row_ ? 0 : kRowsPerFactor) {}

  static Fold zero_fold(const ObservationModel& model, const ReadingLaw& law, FoldBy by) {
    const int p = model.unknowns();
    Fold zero;
    (by == FoldBy::qr ? zero.factor : zero.products) = Eigen::MatrixXd::Zero(p + 1, p + 1);
    if (by == FoldBy::normal_equations && law.degrees_of_freedom > 0)
      zero.bend = Eigen::MatrixXd::Zero(p, p);
    return zero;
  }

  Fold of(int begin, int end) {
    for (int first = begin; first < end; first += kRowsAtOnce) {
      const int count = std::min(kRowsAtOnce, end - first);
      const int place = by_row_ ? 0 : filled_;  // in `rows_`
      if (!kept_)
        at_.blocks_of_predictions(first, count, own_rows(place, count));
      else if (!model_.has_replicates())
        at_.residuals(first, std::span(residuals_).first(static_cast<size_t>(count)));
      for (int k = 0; k < count; ++k) add(first + k, place + k);
      if (filled_ == kRowsPerFactor || first + count == end) empty();
    }
    take_rest();
    return std::move(folded_);
  }

 private:
  // Keeps the columns of `rows_` from falling on the same lines of the cache.
  static constexpr int kPadding = 8;

  Eigen::Block<Eigen::MatrixXd> own_rows(int place, int count) {
    return rows_.middleRows(place * model_.row_size(), count * model_.row_size());
  }

  void add(int prediction, int place) {
    auto out = own_rows(place, 1);
    if (by_row_) {
      gather(prediction, place);
      find_runs();
      weigh(prediction, gathered_);
      if (what_ == What::all)
        add_gathered();
      else
        add_products(gathered_, gathered_.cols() - 1, folded_.products.col(0));
      return;
    }
    if (kept_) {
      gather(prediction, place);
      out.setZero();
      for (size_t k = 0; k < nonzero_.size(); ++k)
        out.col(nonzero_[k]) = gathered_.col(static_cast<Eigen::Index>(k));
    }
    weigh(prediction, out);
    ++filled_;
    if (folded_.bend.size() == 0) return;
    const Eigen::Index count = bent_.cols();
    if (filled_slopes_ + count > slopes_.cols()) empty_slopes();
    slopes_.middleCols(filled_slopes_, count) =
        bending_ * (out.leftCols(out.cols() - 1).transpose() * bent_);
    filled_slopes_ += count;
  }

  bool has_several_rows(int prediction) const {
    return model_.rows_by_prediction().rows(prediction).size() > 1;
  }

  // Multiplies the derivatives and the residual of a row by the root of its weight, and adds its
  // loss. Sets `bent_` and `bending_`: with J the weighted derivatives, bending J^T bent are the
  // slopes whose products add up to `bend`.
  template <typename Row>
  void weigh(int prediction, Row&& of_row) {
    if (has_several_rows(prediction)) return weigh_replicates(prediction, of_row);
    const int row = model_.rows_by_prediction().rows(prediction).front();
    const int size = model_.row_size();
    const double squared_norm = of_row.template rightCols<1>().squaredNorm();
    const double variance = law_.variance_of(row), dof = law_.degrees_of_freedom;
    folded_.loss += law_.loss(squared_norm, size, variance);
    if (dof > 0) of_row *= std::sqrt(law_.weight(squared_norm, size, variance));
    // w' = -w^2 / ((nu + d) u), and the rows hold sqrt(w) J and sqrt(w) r.
    bending_ = dof > 0 ? std::sqrt(2 / ((dof + size) * law_.counted(variance))) : 0;
    bent_ = of_row.template rightCols<1>();
  }

  // The same of replicates, as one row. They have one J, so with weights w, W = sum w and
  // m = sum w r / W
  //     sum w [J r]^T [J r] = W [J m]^T [J m] + rest,
  // where the rest is the squares of the readings alone, and with c = 2 w^2 / ((nu + d) u)
  //     sum c (J^T r) (J^T r)^T = J^T (sum c r r^T) J.
  template <typename Row>
  void weigh_replicates(int prediction, Row&& of_row) {
    const int size = model_.row_size();
    const double dof = law_.degrees_of_freedom;
    NumbersOfRow sum = NumbersOfRow::Zero(size);
    SmallMatrix bend = SmallMatrix::Zero(size, size);
    double weights = 0, squares = 0;
    for (int row : model_.rows_by_prediction().rows(prediction)) {
      const NumbersOfRow r = model_.whitened(row, at_.residual(row));
      const double squared_norm = r.squaredNorm(), variance = law_.variance_of(row);
      const double weight = dof > 0 ? law_.weight(squared_norm, size, variance) : 1;
      folded_.loss += law_.loss(squared_norm, size, variance);
      weights += weight;
      sum += weight * r;
      squares += weight * squared_norm;
      if (folded_.bend.size() > 0)
        bend += 2 * weight * weight / ((dof + size) * law_.counted(variance)) * (r * r.transpose());
    }
    of_row.template rightCols<1>() = sum / weights;
    of_row *= std::sqrt(weights);
    rest_ += std::max(0.0, squares - sum.squaredNorm() / weights);
    if (folded_.bend.size() == 0) return;
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(bend);
    const Eigen::MatrixXd root = Eigen::MatrixXd(ldlt.matrixL()) *
                                 ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
    bent_ = ldlt.transpositionsP().transpose() * root;
    bending_ = 1 / std::sqrt(weights);
  }

  // Sets `gathered_` to the columns of a prediction that are not zero and, the last of them, the
  // residual of a single row.
  void gather(int prediction, int place) {
    const int size = model_.row_size(), last = model_.unknowns();
    if (!kept_) {
      const auto block = own_rows(place, 1);
      find_nonzero(block.leftCols(last), nonzero_);
      nonzero_.push_back(last);
      gathered_ = block(Eigen::all, nonzero_);
      return;
    }
    const size_t begin = kept_->first[static_cast<size_t>(prediction)];
    const size_t count = kept_->first[static_cast<size_t>(prediction) + 1] - begin;
    nonzero_.assign(kept_->column.begin() + static_cast<std::ptrdiff_t>(begin),
                    kept_->column.begin() + static_cast<std::ptrdiff_t>(begin + count));
    nonzero_.push_back(last);
    const auto columns = static_cast<Eigen::Index>(count);
    const auto at_size = static_cast<Eigen::Index>(size);
    gathered_.resize(at_size, columns + 1);
    gathered_.leftCols(columns) = Eigen::Map<const Eigen::MatrixXd>(
        kept_->value.data() + begin * static_cast<size_t>(size), at_size, columns);
    const ReadingSigma sigma = model_.sigma();
    const int position = model_.campaign().reading_size().position;
    gathered_.topRows(position) *= kept_->sigma.position / sigma.position;
    gathered_.bottomRows(size - position) *= kept_->sigma.orientation / sigma.orientation;
    if (has_several_rows(prediction)) return;
    const int row = model_.rows_by_prediction().rows(prediction).front();
    gathered_.col(columns) = model_.whitened(
        row, model_.has_replicates() ? at_.residual(row)
                                     : residuals_[static_cast<size_t>(place % kRowsAtOnce)]);
  }

  // A row that few of many unknowns move, as where curves have many knots: only the products of
  // columns that are not zero.
  void add_gathered() {
    const Eigen::Index last = gathered_.cols() - 1;
    for (Eigen::Index j = 0; j <= last; ++j)
      add_products(gathered_, j, folded_.products.col(nonzero_[static_cast<size_t>(j)]));
    if (folded_.bend.size() == 0) return;
    slope_.noalias() = bending_ * (bent_.transpose() * gathered_);
    for (Eigen::Index j = 0; j < last; ++j)
      add_products(slope_, j, folded_.bend.col(nonzero_[static_cast<size_t>(j)]));
  }

  // Columns that are not zero and stand side by side, as the knots of a curve do: from `column` on,
  // in `gathered_` from `place` on.
  struct Run {
    Eigen::Index place, count;
    int column;
  };

  void find_runs() {
    runs_.clear();
    for (size_t k = 0; k < nonzero_.size(); ++k)
      if (k > 0 && nonzero_[k] == nonzero_[k - 1] + 1)
        ++runs_.back().count;
      else
        runs_.push_back({static_cast<Eigen::Index>(k), 1, nonzero_[k]});
  }

  // Adds the products of the j-th column of a row with those up to it.
  void add_products(const RowMajor& row, Eigen::Index j, Eigen::Ref<Eigen::VectorXd> out) const {
    switch (row.rows()) {
      case 1:
        return add_products_of<1>(row, j, out.data());
      case 3:
        return add_products_of<3>(row, j, out.data());
      case 6:
        return add_products_of<6>(row, j, out.data());
      default:
        return add_products_of<Eigen::Dynamic>(row, j, out.data());
    }
  }

  // The compiler knows the number of rows, and that nothing of `row` changes: it takes four columns
  // at once.
  template <int kRows>
  void add_products_of(const RowMajor& row, Eigen::Index j, double* __restrict out) const {
    const Eigen::Index rows = kRows == Eigen::Dynamic ? row.rows() : kRows, stride = row.cols();
    const Eigen::Matrix<double, kRows, 1> own = row.col(j);
    for (const Run& run : runs_) {
      const Eigen::Index count = std::min(run.count, j + 1 - run.place);
      const double* __restrict const others = row.data() + run.place;
      double* __restrict const sums = out + run.column;
      for (Eigen::Index k = 0; k < count; ++k) {
        double sum = own[0] * others[k];
        for (Eigen::Index axis = 1; axis < rows; ++axis)
          sum += own[axis] * others[axis * stride + k];
        sums[k] += sum;
      }
    }
  }

  // Takes the rows into the sums.
  void empty() {
    if (by_row_) return;
    const auto rows = rows_.topRows(filled_ * model_.row_size());
    if (folded_.factor.size() > 0)
      fold_into(folded_.factor, rows);
    else
      folded_.products.selfadjointView<Eigen::Upper>().rankUpdate(rows.transpose());
    empty_slopes();
    filled_ = 0;
  }

  void empty_slopes() {
    if (folded_.bend.size() > 0)
      folded_.bend.selfadjointView<Eigen::Upper>().rankUpdate(slopes_.leftCols(filled_slopes_));
    filled_slopes_ = 0;
  }

  // What replicates have beside their means stands in the corner of the products, and moves no
  // other number of a triangle.
  void take_rest() {
    if (rest_ == 0) return;
    if (folded_.factor.size() == 0) {
      folded_.products(folded_.products.rows() - 1, folded_.products.cols() - 1) += rest_;
      return;
    }
    double& corner = folded_.factor(folded_.factor.rows() - 1, folded_.factor.cols() - 1);
    corner = std::hypot(corner, std::sqrt(rest_));
  }

  const ObservationModel::At& at_;
  const ObservationModel& model_;
  const ReadingLaw& law_;
  const KeptDerivatives* kept_;
  const What what_;
  const bool by_row_;     // each row by itself, without its zeros
  Eigen::MatrixXd rows_;  // weighted, but where each is taken by itself
  std::array<Residual, kRowsAtOnce> residuals_;
  int filled_ = 0;
  Fold folded_;
  double rest_ = 0;         // see weigh_replicates()
  Eigen::MatrixXd slopes_;  // side by side; their products add up to `bend`
  Eigen::Index filled_slopes_ = 0;
  SmallMatrix bent_;  // see weigh()
  double bending_ = 0;
  std::vector<int> nonzero_;
  std::vector<Run> runs_;
  RowMajor gathered_, slope_;
};

Fold folded(const ObservationModel::At& at, const ObservationModel& model, const ReadingLaw& law,
            FoldBy by, const KeptDerivatives* kept) {
  Fold total = BlockFolder::zero_fold(model, law, by);
  for_ordered_blocks<Fold>(
      model.rows_by_prediction().groups(), predictions_per_block(model),
      [&](int begin, int end) { return BlockFolder(at, model, law, by, kept).of(begin, end); },
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
        return BlockFolder(at, model, law, FoldBy::normal_equations, &kept, What::slopes)
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
  // Rows move about as many unknowns as the first.
  const auto reserve = [&](int rows, size_t of_row, KeptDerivatives& kept) {
    const auto count = static_cast<size_t>(rows) * of_row;
    kept.first.reserve(static_cast<size_t>(rows) + 1);
    kept.column.reserve(count);
    kept.value.reserve(count * static_cast<size_t>(size));
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
        if (all.column.empty())
          reserve(predictions, block.column.size() / block.first.size(), all);
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
