#include "variance_shares.h"

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <numeric>

#include "shuffle.h"

namespace armtrue {
namespace {

constexpr size_t kMostInAllOrders = 8;
constexpr int kOrdersDrawn = 64;
constexpr double kSmallestPivot = 1e-9;

// The part of the response that some of the groups explain, each set once.
class Explained {
 public:
  Explained(const std::vector<Eigen::MatrixXd>& groups, const Eigen::VectorXd& response)
      : groups_(groups), response_(response) {}

  double by(const std::vector<bool>& entered) {
    const auto [place, is_new] = known_.try_emplace(entered, 0.0);
    if (is_new) place->second = squares(entered);
    return place->second;
  }

 private:
  double squares(const std::vector<bool>& entered) const {
    Eigen::MatrixXd columns(response_.size(), 0);
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (!entered[g]) continue;
      columns.conservativeResize(Eigen::NoChange, columns.cols() + groups_[g].cols());
      columns.rightCols(groups_[g].cols()) = groups_[g];
    }
    if (columns.cols() == 0) return 0;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    qr.setThreshold(kSmallestPivot);
    const Eigen::VectorXd turned = qr.householderQ().adjoint() * response_;
    return turned.head(qr.rank()).squaredNorm();
  }

  const std::vector<Eigen::MatrixXd>& groups_;
  const Eigen::VectorXd& response_;
  std::map<std::vector<bool>, double> known_;
};

std::vector<std::vector<int>> orders_of_entry(size_t groups, std::uint64_t seed) {
  std::vector<int> order(groups);
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::vector<int>> orders;
  if (groups <= kMostInAllOrders) {
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

}  // namespace

std::vector<double> variance_shares(const std::vector<Eigen::MatrixXd>& groups,
                                    const Eigen::VectorXd& response, std::uint64_t seed) {
  Explained explained(groups, response);
  std::vector<double> shares(groups.size());
  for (const std::vector<int>& order : orders_of_entry(groups.size(), seed)) {
    std::vector<bool> entered(groups.size());
    double before = 0;
    for (int g : order) {
      entered[g] = true;
      const double after = explained.by(entered);
      shares[g] += std::max(0.0, after - before);
      before = after;
    }
  }
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share = total > 0 ? share / total : 0;
  return shares;
}

}  // namespace armtrue
