#include "observation/block_folder.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "linear_algebra/stacked_triangle.h"

namespace armtrue {
namespace {

// With more unknowns most of them are coefficients of splines, and a row depends on few of them.
constexpr int kManyUnknowns = 150;
constexpr int kRowsPerFactor = 256;  // of one factorisation; they stay in the cache
static_assert(kRowsPerFactor % kRowsAtOnce == 0);

}  // namespace

void find_nonzero(const Eigen::Ref<const Eigen::MatrixXd>& row, std::vector<int>& nonzero) {
  nonzero.clear();
  for (int k = 0; k < row.cols(); ++k)
    if ((row.col(k).array() != 0).any()) nonzero.push_back(k);
}

BlockFolder::BlockFolder(const ObservationModel::At& at, const ObservationModel& model,
                         const ReadingLaw& law, FoldBy by, const KeptDerivatives* kept, What what)
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

Fold BlockFolder::zero_fold(const ObservationModel& model, const ReadingLaw& law, FoldBy by) {
  const int p = model.unknowns();
  Fold zero;
  (by == FoldBy::qr ? zero.factor : zero.products) = Eigen::MatrixXd::Zero(p + 1, p + 1);
  if (law.degrees_of_freedom > 0) zero.bend = Eigen::MatrixXd::Zero(p, p);
  return zero;
}

Fold BlockFolder::of(int begin, int end) {
  for (int first = begin; first < end; first += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, end - first);
    const int place = by_row_ ? 0 : filled_;  // in `rows_`
    if (!kept_)
      at_.blocks_of_predictions(first, count, own_rows(place, count));
    else if (!model_.has_replicates())
      at_.residuals(first, std::span(residuals_).first(count));
    for (int k = 0; k < count; ++k) add(first + k, place + k);
    if (filled_ == kRowsPerFactor || first + count == end) empty();
  }
  take_rest();
  return std::move(folded_);
}

void BlockFolder::add(int prediction, int place) {
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
  ++filled_;
  if (!kept_) {
    weigh(prediction, out);
    if (folded_.bend.size() > 0)
      room_for_slopes().noalias() = bending_ * (out.leftCols(out.cols() - 1).transpose() * bent_);
    return;
  }
  gather(prediction, place);
  weigh(prediction, gathered_);
  out.setZero();
  for (size_t k = 0; k < nonzero_.size(); ++k) out.col(nonzero_[k]) = gathered_.col(k);
  if (folded_.bend.size() == 0) return;
  slope_.noalias() = bending_ * (bent_.transpose() * gathered_);
  auto slopes = room_for_slopes();
  slopes.setZero();
  for (size_t k = 0; k + 1 < nonzero_.size(); ++k)
    slopes.row(nonzero_[k]) = slope_.col(k).transpose();
}

Eigen::Block<Eigen::MatrixXd> BlockFolder::room_for_slopes() {
  const Eigen::Index count = bent_.cols();
  if (filled_slopes_ + count > slopes_.cols()) empty_slopes();
  filled_slopes_ += count;
  return slopes_.block(0, filled_slopes_ - count, slopes_.rows(), count);
}

template <typename Row>
void BlockFolder::weigh(int prediction, Row&& of_row) {
  if (has_several_rows(prediction)) return weigh_replicates(prediction, of_row);
  const int row = model_.rows_by_prediction().rows(prediction).front();
  const int size = model_.row_size();
  const double squared_norm = of_row.template rightCols<1>().squaredNorm();
  const double variance = law_.variance_of(row), dof = law_.degrees_of_freedom;
  folded_.loss += law_.loss(squared_norm, size, variance);
  if (dof > 0) of_row *= std::sqrt(law_.weight(squared_norm, size, variance));
  // w' = -w^2 / ((nu + d) u), and the rows hold sqrt(w) J and sqrt(w) r.
  bending_ = dof > 0 ? std::sqrt(2 / ((dof + size) * law_.counted_variance(variance))) : 0;
  bent_ = of_row.template rightCols<1>();
}

template <typename Row>
void BlockFolder::weigh_replicates(int prediction, Row&& of_row) {
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
      bend += 2 * weight * weight / ((dof + size) * law_.counted_variance(variance)) *
              (r * r.transpose());
  }
  of_row.template rightCols<1>() = sum / weights;
  of_row *= std::sqrt(weights);
  rest_ += std::max(0.0, squares - sum.squaredNorm() / weights);
  if (folded_.bend.size() == 0) return;
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(bend);
  const Eigen::MatrixXd root =
      Eigen::MatrixXd(ldlt.matrixL()) * ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  bent_ = ldlt.transpositionsP().transpose() * root;
  bending_ = 1 / std::sqrt(weights);
}

void BlockFolder::gather(int prediction, int place) {
  const int size = model_.row_size(), last = model_.unknowns();
  if (!kept_) {
    const auto block = own_rows(place, 1);
    find_nonzero(block.leftCols(last), nonzero_);
    nonzero_.push_back(last);
    gathered_ = block(Eigen::all, nonzero_);
    return;
  }
  const size_t begin = kept_->first[prediction];
  const size_t count = kept_->first[prediction + 1] - begin;
  nonzero_.assign(kept_->column.begin() + begin, kept_->column.begin() + begin + count);
  nonzero_.push_back(last);
  const Eigen::Index columns = count;
  const Eigen::Index at_size = size;
  gathered_.resize(at_size, columns + 1);
  gathered_.leftCols(columns) =
      Eigen::Map<const Eigen::MatrixXd>(kept_->value.data() + begin * size, at_size, columns);
  const ReadingSigma sigma = model_.sigma();
  const int position = model_.campaign().reading_size().position;
  gathered_.topRows(position) *= kept_->sigma.position / sigma.position;
  gathered_.bottomRows(size - position) *= kept_->sigma.orientation / sigma.orientation;
  if (has_several_rows(prediction)) return;
  const int row = model_.rows_by_prediction().rows(prediction).front();
  gathered_.col(columns) = model_.whitened(
      row, model_.has_replicates() ? at_.residual(row) : residuals_[place % kRowsAtOnce]);
}

void BlockFolder::add_gathered() {
  const Eigen::Index last = gathered_.cols() - 1;
  for (Eigen::Index j = 0; j <= last; ++j)
    add_products(gathered_, j, folded_.products.col(nonzero_[j]));
  if (folded_.bend.size() == 0) return;
  slope_.noalias() = bending_ * (bent_.transpose() * gathered_);
  for (Eigen::Index j = 0; j < last; ++j) add_products(slope_, j, folded_.bend.col(nonzero_[j]));
}

void BlockFolder::find_runs() {
  runs_.clear();
  for (int k = 0; k < std::ssize(nonzero_); ++k)
    if (k > 0 && nonzero_[k] == nonzero_[k - 1] + 1)
      ++runs_.back().count;
    else
      runs_.push_back({k, 1, nonzero_[k]});
}

void BlockFolder::add_products(const RowMajor& row, Eigen::Index j,
                               Eigen::Ref<Eigen::VectorXd> out) const {
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

template <int kRows>
void BlockFolder::add_products_of(const RowMajor& row, Eigen::Index j,
                                  double* __restrict out) const {
  const Eigen::Index rows = kRows == Eigen::Dynamic ? row.rows() : kRows, stride = row.cols();
  const Eigen::Matrix<double, kRows, 1> own = row.col(j);
  for (const Run& run : runs_) {
    const Eigen::Index count = std::min(run.count, j + 1 - run.place);
    const double* __restrict const others = row.data() + run.place;
    double* __restrict const sums = out + run.column;
    for (Eigen::Index k = 0; k < count; ++k) {
      double sum = own[0] * others[k];
      for (Eigen::Index axis = 1; axis < rows; ++axis) sum += own[axis] * others[axis * stride + k];
      sums[k] += sum;
    }
  }
}

void BlockFolder::empty() {
  if (by_row_) return;
  auto rows = rows_.topRows(filled_ * model_.row_size());
  if (folded_.factor.size() > 0)
    fold_rows(folded_.factor, rows);
  else
    folded_.products.selfadjointView<Eigen::Upper>().rankUpdate(rows.transpose());
  empty_slopes();
  filled_ = 0;
}

void BlockFolder::empty_slopes() {
  if (folded_.bend.size() > 0)
    folded_.bend.selfadjointView<Eigen::Upper>().rankUpdate(slopes_.leftCols(filled_slopes_));
  filled_slopes_ = 0;
}

void BlockFolder::take_rest() {
  if (rest_ == 0) return;
  if (folded_.factor.size() == 0) {
    folded_.products(folded_.products.rows() - 1, folded_.products.cols() - 1) += rest_;
    return;
  }
  double& corner = folded_.factor(folded_.factor.rows() - 1, folded_.factor.cols() - 1);
  corner = std::hypot(corner, std::sqrt(rest_));
}

}  // namespace armtrue
