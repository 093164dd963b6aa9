#include "scan.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "ordered_blocks.h"

namespace armtrue {
namespace {

// Less than this of a candidate's own norm left after projection is rounding, not evidence.
constexpr double kSmallestLeft = 1e-5;

// How much the readings of one pose agree beyond what independent readings would: the variance
// inflation 1 + (m - 1) icc of one-way analysis of variance on the position residuals, with the
// unknowns counted against the poses, which determine them.
double estimate_design_effect(const Eigen::VectorXd& residual, const std::vector<int>& pose,
                              int row_size, double unknowns) {
  struct Group {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;
    int count = 0;
  };
  std::map<int, Group> groups;
  for (size_t row = 0; row < pose.size(); ++row) {
    const Eigen::Vector3d r = residual.segment<3>(static_cast<int>(row) * row_size);
    Group& group = groups[pose[row]];
    group.sum += r;
    group.squares += r.squaredNorm();
    ++group.count;
  }
  double between = 0, within = 0, within_freedom = 0, sum_of_sizes_squared = 0;
  for (const auto& [id, group] : groups) {
    const double m = group.count;
    between += group.sum.squaredNorm() / m;
    within += group.squares - group.sum.squaredNorm() / m;
    within_freedom += 3 * (m - 1);
    sum_of_sizes_squared += m * m;
  }
  const double poses = static_cast<double>(groups.size()), rows = static_cast<double>(pose.size());
  const double between_freedom = 3 * poses - 0.5 * unknowns;  // orientation carries about half
  if (within_freedom < 1 || between_freedom < 1 || within <= 0) return 1.0;
  const double mean_square_between = between / between_freedom;
  const double mean_square_within = within / within_freedom;
  const double size = sum_of_sizes_squared / rows;
  const double icc = (mean_square_between - mean_square_within) /
                     (mean_square_between + (size - 1) * mean_square_within);
  return 1.0 + (size - 1) * std::max(0.0, icc);
}

// Poses numbered from zero in the order of their first row; returns how many there are.
int number_poses(const std::vector<int>& pose, std::vector<int>& group_of_row) {
  std::map<int, int> numbers;
  for (int id : pose)
    group_of_row.push_back(numbers.try_emplace(id, static_cast<int>(numbers.size())).first->second);
  return static_cast<int>(numbers.size());
}

// An orthonormal basis of the columns; columns that depend on the others are left out.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd scaled = columns;
  for (int k = 0; k < scaled.cols(); ++k) {
    const double norm = scaled.col(k).norm();
    if (norm > 0) scaled.col(k) /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  const auto rank = qr.rank();
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), rank);
}

}  // namespace

Linearization::Linearization(const CalibrationResult& fit, const Campaign& campaign)
    : row_size_(campaign.has_orientation() ? 6 : 3), pose_(campaign.pose) {
  std::vector<int> all(parameter_count(fit.robot.chain));
  for (size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
  const ObservationModel model(campaign, fit.robot, all, fit.scale);
  const ObservationModel::At at = model.at(Eigen::VectorXd::Zero(model.unknowns()));
  const int size = row_size_, n = campaign.rows() * size, columns = model.unknowns();
  Eigen::MatrixXd blocks(n, columns + 1);
  for_ordered_blocks<int>(
      campaign.rows(), 1024,
      [&](int begin, int end) {
        Eigen::MatrixXd block(size, columns + 1);
        for (int row = begin; row < end; ++row) {
          at.block(row, block);
          blocks.middleRows(row * size, size) = std::sqrt(fit.weights[row]) * block;
        }
        return 0;
      },
      [](int) {});
  const int coefficients = columns - static_cast<int>(all.size());
  jacobian_ = blocks.leftCols(kTargetParameters);
  model_.resize(n, static_cast<int>(fit.set.kept.size()) + coefficients);
  for (size_t k = 0; k < fit.set.kept.size(); ++k)
    model_.col(static_cast<int>(k)) = blocks.col(fit.set.kept[k]);
  model_.rightCols(coefficients) = blocks.middleCols(static_cast<int>(all.size()), coefficients);
  int column = static_cast<int>(fit.set.kept.size());
  effect_coefficients_.resize(coefficients);
  int c = 0;
  for (const Effect& effect : fit.robot.effects) {
    first_effect_column_.push_back(column);
    column += static_cast<int>(effect.coefficients.size());
    for (const Coefficient& coefficient : effect.coefficients)
      effect_coefficients_[c++] = coefficient.value;
  }
  first_effect_column_.push_back(column);
  full_residual_ = blocks.rightCols<1>();
  equations_ = static_cast<double>(n);
  project();
  design_effect_ =
      estimate_design_effect(residual_, pose_, row_size_, static_cast<double>(model_.cols()));
}

void Linearization::project() {
  basis_ = orthonormal_basis(model_);
  const int rank = static_cast<int>(basis_.cols()), parameters = static_cast<int>(jacobian_.cols());
  const int size = row_size_;
  basis_products_.assign(parameters, Eigen::MatrixXd(rows(), rank));
  for_ordered_blocks<int>(
      parameters, 4,
      [&](int begin, int end) {
        for (int c = begin; c < end; ++c)
          for (int row = 0; row < rows(); ++row)
            basis_products_[c].row(row).noalias() =
                jacobian_.col(c).segment(row * size, size).transpose() *
                basis_.middleRows(row * size, size);
        return 0;
      },
      [](int) {});
  set_residual(full_residual_);
}

void Linearization::set_residual(const Eigen::VectorXd& residual) {
  residual_ = residual - basis_ * (basis_.transpose() * residual);
  residual_norm_ = residual_.squaredNorm();
  const int size = row_size_;
  residual_products_.resize(rows(), jacobian_.cols());
  for (int c = 0; c < jacobian_.cols(); ++c)
    for (int row = 0; row < rows(); ++row)
      residual_products_(row, c) =
          jacobian_.col(c).segment(row * size, size).dot(residual_.segment(row * size, size));
}

Eigen::VectorXd Linearization::contribution(int effect) const {
  const int first = first_effect_column_[effect];
  const int count = first_effect_column_[effect + 1] - first;
  const int offset = first - first_effect_column_[0];
  return model_.middleCols(first, count) * effect_coefficients_.segment(offset, count);
}

Linearization Linearization::without_effect(int effect) const {
  Linearization reduced = *this;
  const int first = first_effect_column_[effect];
  const int count = first_effect_column_[effect + 1] - first;
  const auto tail = model_.cols() - first - count;
  reduced.full_residual_ = full_residual_ + contribution(effect);
  reduced.model_.resize(Eigen::NoChange, model_.cols() - count);
  reduced.model_ << model_.leftCols(first), model_.rightCols(tail);
  reduced.first_effect_column_.erase(reduced.first_effect_column_.begin() + effect);
  for (size_t e = static_cast<size_t>(effect); e < reduced.first_effect_column_.size(); ++e)
    reduced.first_effect_column_[e] -= count;
  const int offset = first - first_effect_column_[0];
  Eigen::VectorXd coefficients(effect_coefficients_.size() - count);
  coefficients << effect_coefficients_.head(offset),
      effect_coefficients_.tail(effect_coefficients_.size() - offset - count);
  reduced.effect_coefficients_ = coefficients;
  reduced.project();
  return reduced;
}

CandidateScan::CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                             const Campaign& campaign)
    : robot_(robot) {
  // Candidates that read the same values of driver and shape stand together, to compute them once.
  std::map<std::string, std::vector<int>> groups;
  std::vector<std::string> order;
  bool needs_frames = false, needs_jacobian = false;
  for (const Candidate& candidate : candidates) {
    BoundEffect bound(candidate.effect, robot, campaign.temperature_names);
    if (bound.coefficient_count() == 0) continue;  // gravity does no work on this parameter
    needs_frames |= bound.needs_frames();
    needs_jacobian |= bound.needs_jacobian();
    const Effect& e = candidate.effect;
    std::string key = to_string(e.driver) + "|" + to_string(e.shape) + "|" +
                      std::to_string(static_cast<int>(e.shape.basis)) + "|" +
                      std::to_string(e.shape.count) + "|" + std::to_string(e.shape.at) + "|" +
                      std::to_string(e.shape.tau);
    if (e.driver.kind == DriverKind::moment || e.driver.kind == DriverKind::force)
      key += "|" + e.parameter;
    const auto [place, is_new] = groups.try_emplace(key);
    if (is_new) order.push_back(key);
    place->second.push_back(static_cast<int>(candidates_.size()));
    candidates_.push_back(candidate);
    bound_.push_back(std::move(bound));
  }
  for (const std::string& key : order) groups_.push_back(groups[key]);

  const ChainEvaluator chain(robot.chain);
  for (int row = 0; row < campaign.rows(); ++row) {
    contexts_.push_back(campaign.context(row));
    if (needs_frames) frames_.push_back(chain.link_frames(contexts_.back().q));
    if (needs_jacobian) chain.pose(contexts_.back().q, jacobians_.emplace_back());
  }
}

Eigen::MatrixXd CandidateScan::values_of(int candidate) const {
  const BoundEffect& bound = bound_[candidate];
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(
      static_cast<int>(contexts_.size()), bound.value_count());
  for (size_t row = 0; row < contexts_.size(); ++row)
    bound.values(contexts_[row], frames_.empty() ? nullptr : &frames_[row],
                 jacobians_.empty() ? nullptr : &jacobians_[row],
                 values.row(static_cast<int>(row)).data());
  return values;
}

Eigen::MatrixXd CandidateScan::columns(const Linearization& fit, int candidate) const {
  const Eigen::MatrixXd values = values_of(candidate);
  const int size = fit.row_size_;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(fit.rows() * size, bound_[candidate].coefficient_count());
  for (const BoundEffect::Term& term : bound_[candidate].terms())
    for (int row = 0; row < fit.rows(); ++row)
      columns.col(term.coefficient).segment(row * size, size) +=
          values(row, term.value) * fit.jacobian_.col(term.parameter).segment(row * size, size);
  return columns;
}

double CandidateScan::variation(const Linearization& fit, int candidate,
                                const Eigen::VectorXd& coefficients) const {
  const Eigen::MatrixXd values = values_of(candidate);
  std::map<int, Eigen::VectorXd> offsets;
  for (const BoundEffect::Term& term : bound_[candidate].terms()) {
    auto& offset =
        offsets.try_emplace(term.parameter, Eigen::VectorXd::Zero(fit.rows())).first->second;
    offset += coefficients[term.coefficient] * values.col(term.value);
  }
  double largest = 0;
  for (const auto& [parameter, offset] : offsets)
    largest = std::max(largest, std::sqrt((offset.array() - offset.mean()).square().mean()));
  return largest;
}

// What one candidate needs to be scored against any residual: the projections of its columns.
struct CandidateScan::Projection {
  Eigen::MatrixXd on_basis;  // rank x coefficients
  Eigen::MatrixXd
      inverse;  // of the Gram matrix of what is left of the columns; zero where dependent
  int degrees_of_freedom = 0;
  double left = 0;
};

CandidateScan::Projection CandidateScan::project(const Linearization& fit, int candidate,
                                                 const Eigen::MatrixXd& values) const {
  const BoundEffect& bound = bound_[candidate];
  const int k = bound.coefficient_count(), size = fit.row_size_;
  Projection projection;
  projection.on_basis = Eigen::MatrixXd::Zero(fit.basis_.cols(), k);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(k, k);
  if (bound.parameters().size() == 1) {
    const int c = bound.parameters().front();
    const Eigen::VectorXd squares =
        fit.jacobian_.col(c).reshaped(size, fit.rows()).colwise().squaredNorm().transpose();
    projection.on_basis.noalias() = fit.basis_products_[c].transpose() * values;
    gram.noalias() = values.transpose() * squares.asDiagonal() * values;
  } else {
    for (const BoundEffect::Term& term : bound.terms())
      projection.on_basis.col(term.coefficient).noalias() +=
          fit.basis_products_[term.parameter].transpose() * values.col(term.value);
    const Eigen::MatrixXd whole = columns(fit, candidate);
    gram.noalias() = whole.transpose() * whole;
  }
  const Eigen::VectorXd own = gram.diagonal();
  gram.noalias() -= projection.on_basis.transpose() * projection.on_basis;

  // Pivoted Cholesky in units of each column's own norm; a pivot below the threshold is nothing
  // new.
  projection.inverse = Eigen::MatrixXd::Zero(k, k);
  std::vector<int> kept;
  for (int c = 0; c < k; ++c) {
    if (own[c] <= 0) continue;
    const double left = std::max(0.0, gram(c, c)) / own[c];
    projection.left = std::max(projection.left, std::sqrt(left));
    if (left < kSmallestLeft * kSmallestLeft) continue;
    std::vector<int> trial = kept;
    trial.push_back(c);
    const Eigen::VectorXd unit = gram.diagonal()(trial).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = unit.asDiagonal() * gram(trial, trial) * unit.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
    if (llt.info() != Eigen::Success) continue;
    const double pivot =
        llt.matrixLLT()(static_cast<int>(trial.size()) - 1, static_cast<int>(trial.size()) - 1);
    if (pivot * pivot < 1e-6) continue;
    kept = trial;
  }
  projection.degrees_of_freedom = static_cast<int>(kept.size());
  if (!kept.empty()) {
    const Eigen::VectorXd unit = gram.diagonal()(kept).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = unit.asDiagonal() * gram(kept, kept) * unit.asDiagonal();
    const int m = static_cast<int>(kept.size());
    projection.inverse(kept, kept) =
        unit.asDiagonal() * scaled.llt().solve(Eigen::MatrixXd::Identity(m, m)) * unit.asDiagonal();
  }
  return projection;
}

double CandidateScan::ebic_fall(const Linearization& fit, int candidate, int degrees_of_freedom,
                                double gain, double residual_norm) const {
  if (degrees_of_freedom == 0) return -std::numeric_limits<double>::infinity();
  const double n = fit.equations() / fit.design_effect();
  const double left = std::max(1e-12, 1.0 - gain / residual_norm);
  return -n * std::log(left) - degrees_of_freedom * std::log(n) -
         2.0 * candidates_[candidate].log_choices;
}

std::vector<CandidateScore> CandidateScan::score(const Linearization& fit) const {
  std::vector<CandidateScore> scores(candidates_.size());
  for_ordered_blocks<int>(
      static_cast<int>(groups_.size()), 8,
      [&](int begin, int end) {
        for (int g = begin; g < end; ++g) {
          const Eigen::MatrixXd values = values_of(groups_[g].front());
          for (int candidate : groups_[g]) {
            const Projection projection = project(fit, candidate, values);
            Eigen::VectorXd slope = Eigen::VectorXd::Zero(bound_[candidate].coefficient_count());
            for (const BoundEffect::Term& term : bound_[candidate].terms())
              slope[term.coefficient] +=
                  values.col(term.value).dot(fit.residual_products_.col(term.parameter));
            CandidateScore& score = scores[candidate];
            score.degrees_of_freedom = projection.degrees_of_freedom;
            score.left = projection.left;
            score.coefficients = projection.inverse * slope;
            score.gain = slope.dot(score.coefficients);
            score.score = ebic_fall(fit, candidate, score.degrees_of_freedom, score.gain,
                                    fit.residual_norm());
          }
        }
        return 0;
      },
      [](int) {});
  return scores;
}

double CandidateScan::family_wise_p(const Linearization& fit, double best_score, int flips,
                                    std::uint64_t seed) const {
  // One sign for each pose in each draw; the same for every candidate. What flips together is
  // summed first.
  std::vector<int> group_of_row;
  const int poses = number_poses(fit.pose_, group_of_row);
  std::mt19937_64 random(seed);
  Eigen::MatrixXf signs(poses, flips);
  for (int f = 0; f < flips; ++f)
    for (int pose = 0; pose < poses; ++pose) signs(pose, f) = random() >> 63 ? 1.0f : -1.0f;
  const auto by_pose = [&](const Eigen::MatrixXd& rows) {
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(poses, rows.cols());
    for (int row = 0; row < rows.rows(); ++row) sums.row(group_of_row[row]) += rows.row(row);
    return Eigen::MatrixXf(sums.cast<float>());  // a rank among draws needs no more digits
  };
  const int n = fit.rows(), size = fit.row_size_;
  Eigen::MatrixXd basis_by_row(n, fit.basis_.cols());
  for (int row = 0; row < n; ++row)
    basis_by_row.row(row) = fit.residual_.segment(row * size, size).transpose() *
                            fit.basis_.middleRows(row * size, size);
  const Eigen::MatrixXf on_basis = by_pose(basis_by_row).transpose() * signs;  // rank x flips
  const Eigen::RowVectorXf norms =
      (static_cast<float>(fit.residual_norm()) - on_basis.colwise().squaredNorm().array()).matrix();

  Eigen::VectorXd best = Eigen::VectorXd::Constant(flips, -std::numeric_limits<double>::infinity());
  for_ordered_blocks<Eigen::VectorXd>(
      static_cast<int>(groups_.size()), 8,
      [&](int begin, int end) {
        Eigen::VectorXd block_best =
            Eigen::VectorXd::Constant(flips, -std::numeric_limits<double>::infinity());
        for (int g = begin; g < end; ++g) {
          const Eigen::MatrixXd values = values_of(groups_[g].front());
          for (int candidate : groups_[g]) {
            const Projection projection = project(fit, candidate, values);
            if (projection.degrees_of_freedom == 0) continue;
            Eigen::MatrixXd weighted =
                Eigen::MatrixXd::Zero(n, bound_[candidate].coefficient_count());
            for (const BoundEffect::Term& term : bound_[candidate].terms())
              weighted.col(term.coefficient) +=
                  values.col(term.value).cwiseProduct(fit.residual_products_.col(term.parameter));
            // In units in which the inverse is near one: columns differ by orders of magnitude.
            const Eigen::VectorXd unit = projection.inverse.diagonal().cwiseSqrt();
            const Eigen::VectorXd back = (unit.array() > 0).select(unit.cwiseInverse(), 0.0);
            const Eigen::MatrixXf inverse =
                (back.asDiagonal() * projection.inverse * back.asDiagonal()).cast<float>();
            const Eigen::MatrixXf sums = by_pose(weighted * unit.asDiagonal());
            Eigen::MatrixXf slopes = sums.transpose() * signs;
            slopes.noalias() -=
                (projection.on_basis * unit.asDiagonal()).cast<float>().transpose() * on_basis;
            const Eigen::RowVectorXf gains = slopes.cwiseProduct(inverse * slopes).colwise().sum();
            for (int f = 0; f < flips; ++f)
              block_best[f] = std::max(
                  block_best[f],
                  ebic_fall(fit, candidate, projection.degrees_of_freedom, gains[f], norms[f]));
          }
        }
        return block_best;
      },
      [&](const Eigen::VectorXd& block) { best = best.cwiseMax(block); });
  const auto as_high = (best.array() >= best_score).count();
  return (1.0 + static_cast<double>(as_high)) / (1.0 + flips);
}

}  // namespace armtrue
