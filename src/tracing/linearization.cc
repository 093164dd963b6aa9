#include "tracing/linearization.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "calibration/pose_influence.h"
#include "calibration/session_models.h"

namespace armtrue {
namespace {

constexpr double kMinPivot = 1e-9;        // of columns of unit length
constexpr double kMinShareOfRefit = 0.1;  // of what an effect does to the readings

// How many readings are worth one independent one. What the model lacks at a pose strikes all of
// its readings alike, so that they agree more than independent ones would: m readings of a pose
// count as m / (1 + (m - 1) icc), where icc is the share of the variance that a pose has in common,
// from one-way analysis of variance of the position residuals (Kish, "Survey Sampling", 1965). The
// unknowns follow the means of the poses, so they are taken off the freedom between poses.
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
    Group& group = groups[campaign.pose_by_quantity(row)];
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
  const double between_freedom = size.position * poses - size.share_of_position() * unknowns;
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
  small.setThreshold(kMinPivot);
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(columns.rows(), small.rank());
  chosen.topRows(p) = small.householderQ() * Eigen::MatrixXd::Identity(p, small.rank());
  return tall.householderQ() * chosen;
}

}  // namespace

Linearization::Linearization(const CalibrationResult& fit, const Campaign& campaign)
    : row_size_(campaign.reading_size().all()), pose_(campaign.pose_by_id()) {
  std::vector<int> all(parameter_count(fit.robot.chain));
  for (size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
  const SessionModels models(campaign, fit.robot, all, fit.sigma);
  const int size = row_size_;
  Eigen::MatrixXd blocks = models.blocks();
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * size, size) *= std::sqrt(fit.weights[row]);
  jacobian_ = blocks.leftCols(kTargetParameters);
  // What a session has of its own is fitted in columns of its own, but an effect moves it in all.
  for (int s = 1; s < models.sessions(); ++s) {
    const ObservationModel& own = models.model(s);
    const ObservationModel model(own.campaign(),
                                 own.robot_at(Eigen::VectorXd::Zero(own.unknowns())), all,
                                 own.sigma(), 0, models.common_from_own(s));
    const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
    Eigen::MatrixXd block(size, model.unknowns() + 1);
    for (int i = 0; i < model.rows(); ++i) {
      const int row = models.rows_of(s)[i];
      at.block(i, block);
      jacobian_.middleRows(row * size, size) =
          std::sqrt(fit.weights[row]) * block.leftCols(kTargetParameters);
    }
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
  mean_psi_derivative_ = mean_psi_derivative(fit.weights, fit.degrees_of_freedom, size);
  design_effect_ = estimate_design_effect(residual_, campaign, static_cast<double>(kept + others));
}

// Of the fitted columns all but those of some effects.
Eigen::ColPivHouseholderQR<Eigen::MatrixXd> Linearization::all_but(
    const std::vector<int>& effects) const {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index column = 0; column < fitted_.cols(); ++column)
    if (std::none_of(effects.begin(), effects.end(), [&](int effect) {
          return column >= first_effect_column_[effect] &&
                 column < first_effect_column_[effect + 1];
        }))
      columns.push_back(column);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fitted_(Eigen::all, columns));
  qr.setThreshold(kMinPivot);
  return qr;
}

Eigen::MatrixXd Linearization::complement(
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd>& qr) const {
  const Eigen::Index rank = fitted_.rows();
  return (qr.householderQ() * Eigen::MatrixXd::Identity(rank, rank)).rightCols(rank - qr.rank());
}

double Linearization::standard_deviation(const Eigen::VectorXd& column) const {
  const Eigen::VectorXd beside = column - basis_ * (basis_.transpose() * column);
  const double length = std::max(beside.norm(), kMinPivot * column.norm());
  const RowsByPose rows = rows_by_pose(pose_);
  const Eigen::Index rank = basis_.cols();
  InfluenceSums sums;
  for (int pose = 0; pose < rows.poses(); ++pose) {
    const int first = rows.first[pose], count = rows.first[pose + 1] - first;
    Eigen::MatrixXd shown(count * row_size_, rank + 1);
    Eigen::VectorXd residual(count * row_size_);
    for (int k = 0; k < count; ++k) {
      const int from = rows.row[first + k] * row_size_, to = k * row_size_;
      shown.middleRows(to, row_size_) << basis_.middleRows(from, row_size_),
          beside.segment(from, row_size_) / length;
      residual.segment(to, row_size_) = residual_.segment(from, row_size_);
    }
    sums.add(influence_of_pose(shown, residual));
  }
  const double freedom = static_cast<double>(residual_.size() - basis_.cols() - 1);
  const double variance = residual_norm_ / std::max(1.0, freedom);
  return std::sqrt(sums.covariance(mean_psi_derivative_, variance)(rank, rank)) / length;
}

Linearization::Loss Linearization::without(const std::vector<int>& effects) const {
  Loss loss;
  loss.span = complement(all_but(effects));
  Eigen::VectorXd readings = explained_;
  for (int effect : effects) readings += contribution_[effect];
  loss.residual = loss.span.transpose() * readings;
  return loss;
}

BesideTheRest Linearization::effects_from(int first) const {
  std::vector<int> effects(contribution_.size() - first);
  std::iota(effects.begin(), effects.end(), first);
  const Loss loss = without(effects);
  BesideTheRest beside;
  for (int e : effects) {
    const int begin = first_effect_column_[e], count = first_effect_column_[e + 1] - begin;
    beside.columns.push_back(loss.span.transpose() * fitted_.middleCols(begin, count));
  }
  beside.readings = loss.residual;
  beside.span = basis_ * loss.span;
  beside.residual = residual_;
  beside.pose = pose_;
  beside.row_size = row_size_;
  return beside;
}

std::vector<int> Linearization::most_refitted(int effect, const Eigen::VectorXd& imitation,
                                              int count) const {
  const Eigen::VectorXd moved =
      all_but({effect}).solve(basis_.transpose() * imitation - contribution_[effect]);
  std::vector<int> order;
  for (int k = 0; k < first_effect_column_.front(); ++k)
    if (std::abs(moved[k]) > kMinShareOfRefit * contribution_[effect].norm()) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(moved[a]) > std::abs(moved[b]); });
  order.resize(std::min(order.size(), static_cast<size_t>(count)));
  return order;
}

}  // namespace armtrue
