#include "search/variance_shares.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "linear_algebra/decompositions.h"
#include "statistics/ordered_blocks.h"
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
  explicit Entry(const BesideTheRest& beside) : basis_(beside.readings.size(), 0) {}

  void enter(const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::VectorXd> left) {
    Eigen::MatrixXd added = columns;
    for (int twice = 0; twice < 2; ++twice) added -= basis_ * (basis_.transpose() * added);
    for (Eigen::Index k = 0; k < added.cols(); ++k)
      if (added.col(k).norm() < kMinOwnPart * columns.col(k).norm()) added.col(k).setZero();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(added);
    qr.setThreshold(kMinOwnPart);
    const Eigen::Index rank = qr.rank(), known = basis_.cols();
    basis_.conservativeResize(Eigen::NoChange, known + rank);
    basis_.rightCols(rank) = first_columns(qr.householderQ(), rank);
    left -= basis_.rightCols(rank) * (basis_.rightCols(rank).transpose() * left);
  }

 private:
  Eigen::MatrixXd basis_;
};

// What is left of the readings where the groups enter in this order, before the first of them and
// after each: coordinates x (groups + 1).
void leave_in_order(const BesideTheRest& beside, const std::vector<int>& order,
                    Eigen::Ref<Eigen::MatrixXd> left) {
  left.col(0) = beside.readings;
  Entry entry(beside);
  for (Eigen::Index k = 0; k < std::ssize(order); ++k) {
    left.col(k + 1) = left.col(k);
    entry.enter(beside.columns[order[k]], left.col(k + 1));
  }
}

// Squares of what is left of the readings (columns of `left`), by pose: poses x columns.
Eigen::MatrixXd squares_by_pose(const BesideTheRest& beside, const Eigen::MatrixXd& left) {
  const Eigen::MatrixXd rows = (beside.span * left).colwise() + beside.residual;
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(beside.poses(), left.cols());
  for (size_t row = 0; row < beside.pose.size(); ++row)
    squares.row(beside.pose[row]) +=
        rows.middleRows(static_cast<Eigen::Index>(row) * beside.row_size, beside.row_size)
            .colwise()
            .squaredNorm();
  return squares;
}

// Fall of the sum of squares of each pose by each group, where they enter in these orders: the sum
// over the orders, poses x groups. The derivatives of a fall with respect to the weight of a pose
// are the squares at that pose: the fit, being the best, moves them in second order only.
Eigen::MatrixXd explained_in(const BesideTheRest& beside,
                             std::span<const std::vector<int>> orders) {
  const auto groups = std::ssize(orders.front()), columns = groups + 1;
  Eigen::MatrixXd left(beside.readings.size(), std::ssize(orders) * columns);
  for (Eigen::Index k = 0; k < std::ssize(orders); ++k)
    leave_in_order(beside, orders[k], left.middleCols(k * columns, columns));
  const Eigen::MatrixXd squares = squares_by_pose(beside, left);
  Eigen::MatrixXd explained = Eigen::MatrixXd::Zero(squares.rows(), groups);
  Eigen::Index column = 0;
  for (const std::vector<int>& order : orders) {
    for (int group : order) {
      explained.col(group) += squares.col(column) - squares.col(column + 1);
      ++column;
    }
    ++column;
  }
  return explained;
}

}  // namespace

double VarianceShares::standard_deviation(const Eigen::VectorXd& weights) const {
  const double poses = static_cast<double>(influence.rows());
  return std::sqrt(poses / std::max(1.0, poses - 1)) * (influence * weights).norm();
}

VarianceShares variance_shares(const BesideTheRest& beside, std::uint64_t seed) {
  const std::vector<std::vector<int>> orders = orders_of_entry(beside.columns.size(), seed);
  const Eigen::Index groups = beside.columns.size();
  Eigen::MatrixXd explained = Eigen::MatrixXd::Zero(beside.poses(), groups);
  constexpr int kOrdersPerBlock = 8;  // their sums wait for each other in memory
  for_ordered_blocks<Eigen::MatrixXd>(
      static_cast<int>(orders.size()), kOrdersPerBlock,
      [&](int begin, int end) {
        return explained_in(beside, std::span(orders).subspan(begin, end - begin));
      },
      [&](const Eigen::MatrixXd& sum) { explained += sum; });
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
