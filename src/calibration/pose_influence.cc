#include "calibration/pose_influence.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kFewOf = 4;  // fewer than a quarter are few
constexpr Eigen::Index kNowhere = -1;
constexpr double kOnlyThere = 1e-6;      // share of a direction that other poses show too
constexpr double kSmallLeverage = 0.03;  // two terms of the series are exact to its square

}  // namespace

Eigen::MatrixXd weighted_rows(const SessionModels::At& at, const std::vector<double>& weights,
                              std::span<const int> rows) {
  const int size = at.models().row_size(), p = at.models().unknowns();
  const std::vector<std::vector<int>> replicates = at.replicates_among(rows);
  Eigen::MatrixXd all(std::ssize(replicates) * size, p + 1);
  Eigen::Index top = 0;
  for (const std::vector<int>& own : replicates) {
    auto block = all.middleRows(top, size);
    top += size;
    at.block(own.front(), block);
    double weight = weights[own.front()];
    if (own.size() > 1) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(size);
      weight = 0;
      for (int row : own) {
        weight += weights[row];
        sum += weights[row] * at.residual(row);
      }
      block.col(p) = sum / weight;
    }
    if (weight != 1) block *= std::sqrt(weight);
  }
  return all;
}

Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& information) {
  constexpr double kSmallest = 1e-14;
  // Columns of unit norm before inverting: m and rad differ by orders of magnitude.
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(unit.asDiagonal() * information * unit.asDiagonal())};
  const Eigen::VectorXd& values = eigen.eigenvalues();  // smallest first
  const Eigen::Index rank =
      values.size() == 0 ? 0 : (values.array() > kSmallest * values.tail(1)[0]).count();
  return unit.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
         values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
}

PoseInfluence influence_of_pose(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const Eigen::Index p = rows.cols();
  if (rows.squaredNorm() < kSmallLeverage) {
    const Eigen::VectorXd own = rows.transpose() * residual;
    return {own + rows.transpose() * (rows * own), Eigen::MatrixXd(p, 0)};
  }
  if (rows.rows() > p + 1) {
    Eigen::MatrixXd folded(rows.rows(), p + 1);
    folded << rows, residual;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(folded);
    folded = qr.matrixQR().topRows(p + 1).triangularView<Eigen::Upper>();
    return influence_of_pose(folded.leftCols(p), folded.col(p));
  }
  Eigen::MatrixXd left = -rows * rows.transpose();
  left.diagonal().array() += 1;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(left);
  const Eigen::VectorXd& shares = eigen.eigenvalues();  // smallest first
  const Eigen::Index alone = (shares.array() <= kOnlyThere).count(), others = shares.size() - alone;
  const auto shared = eigen.eigenvectors().rightCols(others);
  const Eigen::VectorXd without =
      shared * (shared.transpose() * residual).cwiseQuotient(shares.tail(others));
  return {rows.transpose() * without, rows.transpose() * eigen.eigenvectors().leftCols(alone)};
}

Eigen::VectorXd leverage_corrected_residual(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                            const Eigen::Ref<const Eigen::VectorXd>& residual) {
  const bool few_rows = rows.rows() <= rows.cols();
  const Eigen::MatrixXd gram = few_rows ? Eigen::MatrixXd(rows * rows.transpose())
                                        : Eigen::MatrixXd(rows.transpose() * rows);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  const Eigen::ArrayXd leverage = eigen.eigenvalues().array();
  const Eigen::ArrayXd left = (1 - leverage).max(0.0);
  // (sqrt(1 / left) - 1) / leverage without division by zero; `left` is 0 for a direction that only
  // this pose shows.
  const Eigen::ArrayXd root = left.sqrt();
  const Eigen::ArrayXd given_back = (left > kOnlyThere).select(1 / (root * (1 + root)), 0.0);
  if (few_rows)
    return residual + eigen.eigenvectors() * (given_back * leverage).matrix().asDiagonal() *
                          (eigen.eigenvectors().transpose() * residual);
  const Eigen::MatrixXd directions = rows * eigen.eigenvectors();
  return residual +
         directions * given_back.matrix().asDiagonal() * (directions.transpose() * residual);
}

SumOfSquares::SumOfSquares(Eigen::Index count)
    : coordinate_at_(count), place_of_(count), squares_(Eigen::MatrixXd::Zero(count, count)) {
  std::iota(coordinate_at_.begin(), coordinate_at_.end(), 0);
  std::iota(place_of_.begin(), place_of_.end(), 0);
}

std::vector<Eigen::Index> SumOfSquares::places_of(const std::vector<Eigen::Index>& coordinates) {
  std::vector<Eigen::Index> places;
  places.reserve(coordinates.size());
  for (const Eigen::Index coordinate : coordinates) {
    if (coordinate >= std::ssize(place_of_)) place_of_.resize(coordinate + 1, kNowhere);
    Eigen::Index& place = place_of_[coordinate];
    if (place == kNowhere) {
      place = std::ssize(coordinate_at_);
      coordinate_at_.push_back(coordinate);
    }
    places.push_back(place);
  }
  if (const Eigen::Index count = std::ssize(coordinate_at_); count > squares_.cols())
    squares_.conservativeResizeLike(Eigen::MatrixXd::Zero(count, count));
  return places;
}

void SumOfSquares::add(const Eigen::Ref<const Eigen::MatrixXd>& vectors,
                       const std::vector<Eigen::Index>& coordinates) {
  const std::vector<Eigen::Index> places = places_of(coordinates);
  const Eigen::Index count = std::ssize(places);
  // Coordinates that nothing stands between, as where each vector has all.
  if (count > 0 && places.back() - places.front() == count - 1 && std::ranges::is_sorted(places))
    squares_.block(places.front(), places.front(), count, count).noalias() +=
        vectors * vectors.transpose();
  else
    squares_(places, places) += vectors * vectors.transpose();
}

void SumOfSquares::add(const SumOfSquares& other) {
  const std::vector<Eigen::Index> places = places_of(other.coordinate_at_);
  squares_(places, places) += other.squares_;
}

Eigen::MatrixXd SumOfSquares::dense(Eigen::Index count) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  sum(coordinate_at_, coordinate_at_) = squares_;
  return sum;
}

void InfluenceSums::add(const PoseInfluence& pose, const std::vector<Eigen::Index>& coordinates,
                        Eigen::Index count) {
  if (sum_.size() == 0) sum_ = Eigen::VectorXd::Zero(count);
  ++poses_;
  sum_(coordinates) += pose.change;
  squares_.add(pose.change, coordinates);
  if (pose.alone.cols() > 0) alone_.add(pose.alone, coordinates);
}

void InfluenceSums::add(const PoseInfluence& pose) {
  std::vector<Eigen::Index> all(pose.change.size());
  std::iota(all.begin(), all.end(), 0);
  add(pose, all, pose.change.size());
}

void InfluenceSums::add(const InfluenceSums& others) {
  if (others.poses_ == 0) return;
  if (sum_.size() == 0) sum_ = Eigen::VectorXd::Zero(others.sum_.size());
  poses_ += others.poses_;
  sum_ += others.sum_;
  squares_.add(others.squares_);
  alone_.add(others.alone_);
}

Eigen::MatrixXd InfluenceSums::covariance(double mean_psi_derivative, double variance) const {
  const double n = poses_;
  const Eigen::Index p = sum_.size();
  Eigen::MatrixXd covariance = squares_.dense(p);
  covariance.noalias() -= sum_ * (sum_ / n).transpose();
  covariance *= (n - 1) / (n * mean_psi_derivative * mean_psi_derivative);
  if (!alone_.is_empty()) covariance += variance * alone_.dense(p);
  return covariance;
}

double mean_psi_derivative(const std::vector<double>& weights, double degrees_of_freedom,
                           int dimension) {
  if (degrees_of_freedom <= 0) return 1;
  double held = 0, sum = 0;
  for (double w : weights) {
    // s / (dof + s) of a squared norm s
    const double far = 1 - degrees_of_freedom * w / (degrees_of_freedom + dimension);
    held += w * (1 - 2.0 / dimension * far);
    sum += w;
  }
  return held / sum;
}

Eigen::MatrixXd product_without_zeros(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                      const Eigen::MatrixXd& root) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    if ((rows.col(k).array() != 0).any()) columns.push_back(k);
  if (std::ssize(columns) * kFewOf >= rows.cols()) return rows * root;
  return rows(Eigen::all, columns) * root(columns, Eigen::all);
}

GroupedRows some_poses(const GroupedRows& all, int count) {
  if (all.groups() <= count) return all;
  GroupedRows some{{0}, {}};
  for (long k = 0; k < count; ++k) {
    some.add(all.rows(static_cast<int>(k * all.groups() / count)));
  }
  return some;
}

int poses_per_block(int poses) {
  constexpr int kPosesPerBlock = 32, kMaxBlocks = 256;
  return std::max(kPosesPerBlock, (poses + kMaxBlocks - 1) / kMaxBlocks);
}

std::vector<int> poses_by_group(const SessionModels::At& at, const GroupedRows& rows) {
  std::vector<int> order(rows.groups());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {},
                           [&](int pose) { return at.group_of(rows.row[rows.first[pose]]); });
  return order;
}

RootsOfGroups::RootsOfGroups(const SessionModels& models, const SparseRows& root) {
  for (int g = 0; g < models.groups(); ++g) {
    std::vector<Eigen::Index> unknowns;
    for (const SessionModels::Run& run : models.runs(g))
      for (int k = run.first; k < run.first + run.count; ++k) unknowns.push_back(k);
    RootOfGroup& group = groups_.emplace_back();
    std::vector<Eigen::Index>& coordinates = group.coordinates;
    for (const Eigen::Index unknown : unknowns)
      for (SparseRows::InnerIterator entry(root, unknown); entry; ++entry)
        coordinates.push_back(entry.col());
    std::ranges::sort(coordinates);
    coordinates.erase(std::unique(coordinates.begin(), coordinates.end()), coordinates.end());
    group.root = Eigen::MatrixXd::Zero(std::ssize(unknowns), std::ssize(coordinates));
    for (size_t k = 0; k < unknowns.size(); ++k)
      for (SparseRows::InnerIterator entry(root, unknowns[k]); entry; ++entry)
        group.root(k, std::ranges::lower_bound(coordinates, entry.col()) - coordinates.begin()) =
            entry.value();
  }
}

Eigen::MatrixXd RootsOfGroups::of_row(const SessionModels::At& at, int row) const {
  const Eigen::MatrixXd& root = groups_[at.group_of(row)].root;
  Eigen::MatrixXd block(at.models().row_size(), root.rows() + 1);
  at.own_block(row, block);
  return block.leftCols(root.rows()) * root;
}

PoseRows RootsOfGroups::rows_of(const SessionModels::At& at, const std::vector<double>& weights,
                                const GroupedRows& rows, int pose) const {
  const std::span<const int> own = rows.rows(pose);
  PoseRows result;
  for (const int row : own) {
    const std::vector<Eigen::Index>& more = groups_[at.group_of(row)].coordinates;
    if (more == result.coordinates) continue;
    std::vector<Eigen::Index> both;
    std::ranges::set_union(result.coordinates, more, std::back_inserter(both));
    result.coordinates = std::move(both);
  }
  const Eigen::Index size = at.models().row_size(), numbers = size * std::ssize(own);
  result.rows = Eigen::MatrixXd::Zero(numbers, std::ssize(result.coordinates));
  result.residual.resize(numbers);
  Eigen::Index first = 0;
  for (const int row : own) {
    const RootOfGroup& group = groups_[at.group_of(row)];
    const Eigen::Index unknowns = group.root.rows();
    Eigen::MatrixXd block(size, unknowns + 1);
    at.own_block(row, block);
    if (weights[row] != 1) block *= std::sqrt(weights[row]);
    const Eigen::MatrixXd shown = block.leftCols(unknowns) * group.root;
    for (Eigen::Index k = 0; k < shown.cols(); ++k) {
      const auto place = std::ranges::lower_bound(result.coordinates, group.coordinates[k]);
      result.rows.col(place - result.coordinates.begin()).segment(first, size) = shown.col(k);
    }
    result.residual.segment(first, size) = block.col(unknowns);
    first += size;
  }
  return result;
}

}  // namespace armtrue
