#include "search/variance_shares.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "linear_algebra/decompositions.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

constexpr size_t kMaxInAllOrders = 5;
constexpr int kOrdersDrawn = 64;      // and their reverses; the mean is good to a per cent
constexpr double kMinOwnPart = 1e-9;  // of columns of unit length

std::vector<std::vector<int>> orders_of_entry(size_t groups, std::uint64_t seed) {
  std::vector<int> order(groups);
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::vector<int>> orders;
  if (groups <= kMaxInAllOrders) {
    do orders.push_back(order);
    while (std::next_permutation(order.begin(), order.end()));
    return orders;
  }
  for (int k = 0; k < kOrdersDrawn; ++k) {
    shuffle(order, seed + static_cast<std::uint64_t>(k));
    orders.push_back(order);
    orders.emplace_back(order.rbegin(), order.rend());
  }
  return orders;
}

// Readings from which groups of columns are projected off one after the other.
class Entry {
 public:
  explicit Entry(const BesideTheRest& beside)
      : beside_(beside),
        basis_(beside.readings.size(), 0),
        left_(beside.readings),
        by_pose_(squares_by_pose()) {}

  // Fall of the sum of squares of each pose by the group. Their derivatives with respect to the
  // weight of a pose are the squares at that pose: the fit, being the best, moves them in second
  // order only.
  Eigen::VectorXd enter(const Eigen::MatrixXd& columns) {
    Eigen::MatrixXd added = columns;
    for (int twice = 0; twice < 2; ++twice) added -= basis_ * (basis_.transpose() * added);
    for (Eigen::Index k = 0; k < added.cols(); ++k)
      if (added.col(k).norm() < kMinOwnPart * columns.col(k).norm()) added.col(k).setZero();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(added);
    qr.setThreshold(kMinOwnPart);
    const Eigen::Index rank = qr.rank(), known = basis_.cols();
    basis_.conservativeResize(Eigen::NoChange, known + rank);
    basis_.rightCols(rank) = qr.householderQ() * Eigen::MatrixXd::Identity(added.rows(), rank);
    left_ -= basis_.rightCols(rank) * (basis_.rightCols(rank).transpose() * left_);
    const Eigen::VectorXd before = by_pose_;
    by_pose_ = squares_by_pose();
    return before - by_pose_;
  }

 private:
  Eigen::VectorXd squares_by_pose() const {
    const Eigen::VectorXd rows = beside_.span * left_ + beside_.residual;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(beside_.poses());
    for (size_t row = 0; row < beside_.pose.size(); ++row)
      squares[beside_.pose[row]] +=
          rows.segment(static_cast<Eigen::Index>(row) * beside_.row_size, beside_.row_size)
              .squaredNorm();
    return squares;
  }

  const BesideTheRest& beside_;
  Eigen::MatrixXd basis_;
  Eigen::VectorXd left_, by_pose_;
};

}  // namespace

double VarianceShares::standard_deviation(const Eigen::VectorXd& weights) const {
  const double poses = static_cast<double>(influence.rows());
  return std::sqrt(poses / std::max(1.0, poses - 1)) * (influence * weights).norm();
}

VarianceShares variance_shares(const BesideTheRest& beside, std::uint64_t seed) {
  const std::vector<std::vector<int>> orders = orders_of_entry(beside.columns.size(), seed);
  const auto groups = static_cast<Eigen::Index>(beside.columns.size());
  Eigen::MatrixXd explained = Eigen::MatrixXd::Zero(beside.poses(), groups);
  for (const std::vector<int>& order : orders) {
    Entry entry(beside);
    for (int group : order) explained.col(group) += entry.enter(beside.columns[group]);
  }
  const Eigen::RowVectorXd of_group = explained.colwise().sum().cwiseMax(0);
  const double total = of_group.sum();
  VarianceShares shares{std::vector<double>(groups), Eigen::MatrixXd::Zero(beside.poses(), groups)};
  if (!(total > 0)) return shares;
  const Eigen::RowVectorXd share = of_group / total;
  std::copy(share.begin(), share.end(), shares.of_group.begin());
  shares.influence = (explained - explained.rowwise().sum() * share) / total;
  return shares;
}

}  // namespace armtrue
