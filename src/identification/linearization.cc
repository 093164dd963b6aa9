#include "linearization.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sessions.h"

namespace armtrue {
namespace {

constexpr double kSmallestPivot = 1e-9;  // of columns of unit length
constexpr double kWorthNaming = 0.1;     // of what an effect does to the readings

// How much the readings of one pose agree beyond what independent readings would: the variance
// inflation 1 + (m - 1) icc of one-way analysis of variance on the position residuals, with the
// unknowns counted against the poses, which determine them.
double estimate_design_effect(const Eigen::VectorXd& residual, const Campaign& campaign,
                              double unknowns) {
  const ReadingSize size = campaign.reading_size();
  struct Group {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;
    int count = 0;
  };
  std::map<int, Group> groups;
  for (int row = 0; row < campaign.rows(); ++row) {
    Eigen::Vector3d r = Eigen::Vector3d::Zero();
    r.head(size.position) = residual.segment(row * size.all(), size.position);
    Group& group = groups[campaign.pose_by_anchor(row)];
    group.sum += r;
    group.squares += r.squaredNorm();
    ++group.count;
  }
  double between = 0, within = 0, within_freedom = 0, sum_of_sizes_squared = 0;
  for (const auto& [id, group] : groups) {
    const double m = group.count;
    between += group.sum.squaredNorm() / m;
    within += group.squares - group.sum.squaredNorm() / m;
    within_freedom += size.position * (m - 1);
    sum_of_sizes_squared += m * m;
  }
  const double poses = static_cast<double>(groups.size());
  // Orientation carries about half of the unknowns; a distance has none beside it.
  const double of_position = campaign.has_distances() ? unknowns : 0.5 * unknowns;
  const double between_freedom = size.position * poses - of_position;
  if (within_freedom < 1 || between_freedom < 1 || within <= 0) return 1.0;
  const double mean_square_between = between / between_freedom;
  const double mean_square_within = within / within_freedom;
  const double group_size = sum_of_sizes_squared / campaign.rows();
  const double icc = (mean_square_between - mean_square_within) /
                     (mean_square_between + (group_size - 1) * mean_square_within);
  return 1.0 + (group_size - 1) * std::max(0.0, icc);
}

// Columns of unit length; columns of nothing stay nothing.
Eigen::MatrixXd normalized(Eigen::MatrixXd columns) {
  for (int k = 0; k < columns.cols(); ++k) columns.col(k).normalize();
  return columns;
}

// An orthonormal basis of the columns; columns that depend on the others are left out.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns) {
  // Tall columns are first folded by a blocked decomposition, which is several times faster.
  Eigen::HouseholderQR<Eigen::MatrixXd> tall(columns);
  const Eigen::Index p = std::min(columns.rows(), columns.cols());
  const Eigen::MatrixXd triangle = tall.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> small(triangle);
  small.setThreshold(kSmallestPivot);
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(columns.rows(), small.rank());
  chosen.topRows(p) = small.householderQ() * Eigen::MatrixXd::Identity(p, small.rank());
  return tall.householderQ() * chosen;
}

}  // namespace

Linearization::Linearization(const CalibrationResult& fit, const Campaign& campaign)
    : row_size_(campaign.reading_size().all()), pose_(campaign.pose) {
  std::vector<int> all(parameter_count(fit.robot.chain));
  for (size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
  const SessionModels models(campaign, fit.robot, all, fit.scale);
  const int size = row_size_;
  Eigen::MatrixXd blocks = models.blocks();
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * size, size) *= std::sqrt(fit.weights[row]);
  jacobian_ = blocks.leftCols(kTargetParameters);
  // What a session has of its own is fitted in columns of its own, but an effect moves it in all.
  for (int s = 1; s < models.sessions(); ++s)
    for (size_t k = 0; k < models.own().size(); ++k) {
      const auto own = blocks.col(models.first_own(s) + static_cast<int>(k));
      for (int row : models.rows_of(s))
        jacobian_.col(models.own()[k]).segment(row * size, size) = own.segment(row * size, size);
    }

  const int kept = static_cast<int>(fit.set.kept.size());
  const int others = models.unknowns() - static_cast<int>(all.size());
  Eigen::MatrixXd fitted(blocks.rows(), kept + others);
  fitted << blocks(Eigen::all, fit.set.kept),
      blocks.middleCols(static_cast<int>(all.size()), others);
  const Eigen::VectorXd readings = blocks.rightCols<1>();
  const Eigen::VectorXd length = fitted.colwise().norm();
  fitted = normalized(std::move(fitted));
  basis_ = orthonormal_basis(fitted);
  fitted_ = basis_.transpose() * fitted;
  explained_ = basis_.transpose() * readings;
  residual_ = readings - basis_ * explained_;
  residual_norm_ = residual_.squaredNorm();

  int column = kept;
  for (const Effect& effect : fit.robot.effects) {
    first_effect_column_.push_back(column);
    Eigen::VectorXd contribution = Eigen::VectorXd::Zero(basis_.cols());
    for (const Coefficient& coefficient : effect.coefficients) {
      contribution += fitted_.col(column) * (length[column] * coefficient.value);
      ++column;
    }
    contribution_.push_back(contribution);
  }
  first_effect_column_.push_back(column);
  design_effect_ = estimate_design_effect(residual_, campaign, static_cast<double>(kept + others));
}

Eigen::ColPivHouseholderQR<Eigen::MatrixXd> Linearization::all_but(int effect) const {
  const int first = first_effect_column_[effect], after = first_effect_column_[effect + 1];
  Eigen::MatrixXd rest(fitted_.rows(), fitted_.cols() - (after - first));
  rest << fitted_.leftCols(first), fitted_.rightCols(fitted_.cols() - after);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rest);
  qr.setThreshold(kSmallestPivot);
  return qr;
}

double Linearization::standard_deviation(const Eigen::VectorXd& column) const {
  const double left = column.squaredNorm() - (basis_.transpose() * column).squaredNorm();
  const double variance =
      residual_norm_ / static_cast<double>(residual_.size() - basis_.cols() - 1);
  return std::sqrt(design_effect_ * variance / left);
}

Linearization::Loss Linearization::without_effect(int effect) const {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr = all_but(effect);
  const Eigen::Index rank = fitted_.rows(), own = rank - qr.rank();
  Loss loss;
  loss.span = (qr.householderQ() * Eigen::MatrixXd::Identity(rank, rank)).rightCols(own);
  loss.residual = loss.span.transpose() * (explained_ + contribution_[effect]);
  return loss;
}

std::vector<int> Linearization::most_refitted(int effect, const Eigen::VectorXd& imitation,
                                              int count) const {
  const Eigen::VectorXd moved =
      all_but(effect).solve(basis_.transpose() * imitation - contribution_[effect]);
  std::vector<int> order;
  for (int k = 0; k < first_effect_column_.front(); ++k)
    if (std::abs(moved[k]) > kWorthNaming * contribution_[effect].norm()) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(moved[a]) > std::abs(moved[b]); });
  order.resize(std::min(order.size(), static_cast<size_t>(count)));
  return order;
}

}  // namespace armtrue
