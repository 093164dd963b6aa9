#include "calibration/pose_influence.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kFewOf = 4;       // fewer than a quarter are few
constexpr Eigen::Index kNowhere = -1;
constexpr double kOnlyThere = 1e-6;      // share of a direction that other poses show too
constexpr double kSmallLeverage = 0.03;  // two terms of the series are exact to its square

}  // namespace

Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& information) {
  constexpr double kSmallest = 1e-14;
  // Columns of unit norm before inverting: m and rad differ by orders of magnitude.
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * information *
                                                             unit.asDiagonal());
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

void InfluenceSums::place(const std::vector<Eigen::Index>& unknowns) {
  for (const Eigen::Index unknown : unknowns) {
    if (place_of_[unknown] != kNowhere) continue;
    place_of_[unknown] = std::ssize(unknown_at_);
    unknown_at_.push_back(unknown);
  }
  const Eigen::Index room = squares_.cols(), places = std::ssize(unknown_at_);
  if (places <= room) return;
  const Eigen::Index wider = std::clamp(2 * room, places, std::ssize(place_of_));
  squares_.conservativeResizeLike(Eigen::MatrixXd::Zero(wider, wider));
}

void InfluenceSums::add(const PoseInfluence& pose) {
  const Eigen::Index p = pose.change.size();
  if (poses_++ == 0) {
    sum_ = Eigen::VectorXd::Zero(p);
    place_of_.assign(static_cast<size_t>(p), kNowhere);
  }
  sum_ += pose.change;
  // A pose of one of many sessions changes few of the unknowns.
  const auto changed = static_cast<Eigen::Index>((pose.change.array() != 0).count());
  const bool few = changed * kFewOf < p;
  std::vector<Eigen::Index> unknowns;
  for (Eigen::Index k = 0; k < p; ++k)
    if (!few || pose.change[k] != 0) unknowns.push_back(k);
  place(unknowns);
  if (few) {
    for (const Eigen::Index column : unknowns)
      for (const Eigen::Index row : unknowns)
        squares_(place_of_[row], place_of_[column]) += pose.change[row] * pose.change[column];
  } else {
    const Eigen::VectorXd change = pose.change(unknown_at_);
    squares_.topLeftCorner(change.size(), change.size()).noalias() += change * change.transpose();
  }
  if (pose.alone.cols() == 0) return;
  if (alone_.size() == 0) alone_ = Eigen::MatrixXd::Zero(p, p);
  alone_ += pose.alone * pose.alone.transpose();
}

void InfluenceSums::add(const InfluenceSums& others) {
  if (others.poses_ == 0) return;
  if (poses_ == 0) {
    *this = others;
    return;
  }
  poses_ += others.poses_;
  sum_ += others.sum_;
  place(others.unknown_at_);
  std::vector<Eigen::Index> places;
  for (const Eigen::Index unknown : others.unknown_at_) places.push_back(place_of_[unknown]);
  const Eigen::Index count = std::ssize(places);
  squares_(places, places) += others.squares_.topLeftCorner(count, count);
  if (others.alone_.size() == 0) return;
  if (alone_.size() == 0) alone_ = Eigen::MatrixXd::Zero(sum_.size(), sum_.size());
  alone_ += others.alone_;
}

Eigen::MatrixXd InfluenceSums::covariance(double mean_psi_derivative, double variance) const {
  const double n = poses_;
  const Eigen::Index p = sum_.size();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(p, p);
  const Eigen::Index places = std::ssize(unknown_at_);
  covariance(unknown_at_, unknown_at_) = squares_.topLeftCorner(places, places);
  covariance.noalias() -= sum_ * (sum_ / n).transpose();
  covariance *= (n - 1) / (n * mean_psi_derivative * mean_psi_derivative);
  if (alone_.size() > 0) covariance += variance * alone_;
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

Eigen::MatrixXd product_without_zeros(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                                      const SparseRows& root) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(rows.rows(), root.cols());
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    if ((rows.col(k).array() == 0).all()) continue;
    for (SparseRows::InnerIterator entry(root, k); entry; ++entry)
      product.col(entry.col()) += entry.value() * rows.col(k);
  }
  return product;
}

RowsByPose rows_by_pose(const std::vector<int>& pose) {
  const int numbers = pose.empty() ? 0 : 1 + *std::max_element(pose.begin(), pose.end());
  RowsByPose rows{std::vector<int>(numbers + 1, 0), std::vector<int>(pose.size())};
  for (int k : pose) ++rows.first[k + 1];
  for (int k = 0; k < numbers; ++k) rows.first[k + 1] += rows.first[k];
  std::vector<int> next = rows.first;
  for (size_t row = 0; row < pose.size(); ++row)
    rows.row[next[pose[row]]++] = static_cast<int>(row);
  rows.first.erase(std::unique(rows.first.begin(), rows.first.end()), rows.first.end());
  return rows;
}

RowsByPose some_poses(const RowsByPose& all, int count) {
  if (all.poses() <= count) return all;
  RowsByPose some{{0}, {}};
  for (int k = 0; k < count; ++k) {
    const auto pose = static_cast<size_t>(static_cast<long>(k) * all.poses() / count);
    some.row.insert(some.row.end(), all.row.begin() + all.first[pose],
                    all.row.begin() + all.first[pose + 1]);
    some.first.push_back(static_cast<int>(some.row.size()));
  }
  return some;
}

}  // namespace armtrue
