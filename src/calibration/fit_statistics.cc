#include "calibration/fit_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "armtrue/observation/fold.h"
#include "calibration/covariance.h"
#include "calibration/pose_influence.h"
#include "linear_algebra/bordered_spectrum.h"
#include "linear_algebra/decompositions.h"
#include "linear_algebra/sparse_cholesky.h"

namespace armtrue {

Eigen::MatrixXd joint_information(const SessionModels& models,
                                  const std::vector<GroupFold>& folds) {
  if (models.groups() == 1) return folds.front().folded.information();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(models.unknowns(), models.unknowns());
  for (int g = 0; g < models.groups(); ++g) {
    const Eigen::MatrixXd information = folds[g].folded.information();
    int column = 0;
    for (const SessionModels::Run& right : models.runs(g)) {
      int row = 0;
      for (const SessionModels::Run& left : models.runs(g)) {
        sum.block(left.first, right.first, left.count, right.count) +=
            information.block(row, column, left.count, right.count);
        row += left.count;
      }
      column += right.count;
    }
  }
  return sum;
}

namespace {

// Of the information of several groups, and of what is `added` to its diagonal. Nothing if a
// direction is hardly determined that is not that of the same groups alone; nor where a dense
// decomposition is as fast.
std::optional<SparseCholesky> factor_of(const SessionModels& models,
                                        const Eigen::MatrixXd& information,
                                        const Eigen::VectorXd& added = {}) {
  if (models.groups() == 1) return std::nullopt;
  SparseCholesky factor(
      information, added,
      is_sparse(information) ? models.unknowns_by_groups() : SparseCholesky::Blocks{});
  return factor.is_clear() ? std::optional(std::move(factor)) : std::nullopt;
}

// inverse_root() of the information of readings and priors, sparse where factor_of() is.
struct InverseRoot {
  InverseRoot(const SessionModels& models, const Eigen::MatrixXd& of_readings,
              const std::vector<Prior>& priors) {
    const Eigen::VectorXd of_priors = prior_information(priors, of_readings.cols());
    if (const auto factor = factor_of(models, of_readings, of_priors))
      sparse = factor->inverse_root();
    if (sparse.size() > 0) return;
    Eigen::MatrixXd information = of_readings;
    information.diagonal() += of_priors;
    dense = inverse_root(information);
  }

  Eigen::MatrixXd dense;  // empty if the other is there
  SparseRows sparse;
};

}  // namespace

Eigen::Array2d determined_by(const SessionModels& model, const Eigen::MatrixXd& information,
                             const Priors& priors, const Eigen::VectorXd& x) {
  constexpr double kManyPerUnknown = 4;  // equations
  const ReadingSize size = model.campaign().reading_size();
  const int p = model.unknowns();
  if (model.rows() * size.all() > kManyPerUnknown * p || size.orientation == 0)
    return (p - undetermined(information, priors, model.unknowns_by_groups())) *
           Eigen::Array2d(size.share_of_position(), 1 - size.share_of_position());
  const InverseRoot root(model, information, priors.of_unknowns);
  const SessionModels::At at = model.at(x);
  Eigen::Array2d determined = Eigen::Array2d::Zero();
  const auto add = [&](const Eigen::MatrixXd& moved) {
    determined[0] += moved.topRows(size.position).squaredNorm();
    determined[1] += moved.bottomRows(size.orientation).squaredNorm();
  };
  if (root.sparse.size() > 0) {
    const RootsOfGroups roots(model, root.sparse);
    for (int row = 0; row < model.rows(); ++row) add(roots.of_row(at, row));
    return determined;
  }
  Eigen::MatrixXd block(model.row_size(), p + 1);
  for (int row = 0; row < model.rows(); ++row) {
    at.block(row, block);
    add(block.leftCols(p) * root.dense);
  }
  return determined;
}

namespace {

// The triangle of all rows, from the folds of the groups.
Eigen::MatrixXd joint_factor(const SessionModels& models, const std::vector<GroupFold>& folds) {
  std::vector<Eigen::MatrixXd> factors;
  for (const GroupFold& group : folds) factors.push_back(group.folded.factor);
  return models.join(factors);
}

// The folds of all groups at x; one made at another x is computed again.
std::vector<GroupFold> folds_at(const SessionModels& model, const ReadingLaw& law,
                                const Eigen::VectorXd& x, std::vector<GroupFold> folds) {
  folds.resize(model.groups());
  for (int g = 0; g < model.groups(); ++g) {
    const ObservationModel& group = model.model(g);
    const Eigen::VectorXd own = model.unknowns_of(g, x);
    if (folds[g].x.size() != own.size() || folds[g].x != own)
      folds[g].folded = fold(group.at(own), group, model.law_of(g, law));
  }
  return folds;
}

// Sets the weights of the rows and the spread. Returns the weighted mean square of the whitened
// residuals, at least 1.
double set_weights(const SessionModels& model, const ReadingLaw& law, const Eigen::VectorXd& x,
                   CalibrationResult& result) {
  const std::vector<Eigen::Vector2d> norms = model.squared_norms(x);
  result.weights.resize(norms.size());
  result.weights_in_pose.resize(norms.size());
  Eigen::Array2d weighted = Eigen::Array2d::Zero(), all = weighted, within_poses = weighted;
  for (int i = 0; i < std::ssize(norms); ++i) {
    const double variance = law.variance_of(i);
    result.weights[i] = law.weight(norms[i].sum(), model.row_size(), variance);
    result.weights_in_pose[i] = result.weights[i] * variance / law.counted_variance(variance);
    weighted += result.weights[i] * norms[i].array();
    all += result.weights_in_pose[i] * norms[i].array();
    within_poses += result.weights_in_pose[i] / variance * norms[i].array();
  }
  // Sigma is that of the readings without gross poses.
  const Eigen::Array2d widening =
      (within_poses > 0).select((all / within_poses.max(1e-300)).sqrt(), 1.0);
  result.spread = {result.sigma.position * widening[0], result.sigma.orientation * widening[1]};
  return std::max(1.0, weighted.sum() / (model.rows() * model.row_size()));
}

// Of singular values in the units of the literature: rows are multiplied by sigma of position.
struct SingularValues {
  double largest, smallest, geometric_mean, sum_of_inverses;
};

std::array<double, 5> observability(const SingularValues& s, int readings) {
  return {s.geometric_mean / std::sqrt(std::max(1, readings)), s.smallest / s.largest, s.smallest,
          s.smallest * s.smallest / s.largest, 1.0 / s.sum_of_inverses};
}

SingularValues summed_up(const Eigen::VectorXd& s) {
  return {s[0], s[s.size() - 1], std::exp(s.array().max(1e-300).log().mean()),
          s.cwiseInverse().sum()};
}

void set_condition(const SingularValues& s, int rows, CalibrationResult& result) {
  result.condition = s.largest / s.smallest;
  result.observability = observability(s, rows);
}

// The places within `unknowns` that only one group has, of each group.
std::vector<std::vector<Eigen::Index>> own_places(const SessionModels& model,
                                                  const std::vector<int>& unknowns) {
  constexpr int kNobody = -1, kSeveral = -2;
  std::vector<int> owner(model.unknowns(), kNobody);
  for (int g = 0; g < model.groups(); ++g)
    for (const SessionModels::Run& run : model.runs(g))
      for (int k = run.first; k < run.first + run.count; ++k)
        owner[k] = owner[k] == kNobody ? g : kSeveral;
  std::vector<std::vector<Eigen::Index>> places(model.groups());
  for (size_t place = 0; place < unknowns.size(); ++place)
    if (const int group = owner[unknowns[place]]; group >= 0) places[group].push_back(place);
  std::erase_if(places, [](const auto& own) { return own.empty(); });
  return places;
}

// Rank, condition and observability of several groups. They have many unknowns together, and the
// singular values of a triangle of them all take minutes. The roots of the eigenvalues of the
// information are the same, which is block-diagonal but for what the groups have in common. False
// where they have too few right digits, and the triangle takes no longer.
bool set_observability_by_group(const SessionModels& model, const Eigen::MatrixXd& information,
                                CalibrationResult& result) {
  constexpr double kFewDigits = 1e-10, kNoDigits = 1e-14;  // eigenvalue, of the largest
  const std::vector<int> geometric = model.geometric_unknowns();
  const auto factor = factor_of(model, information);
  if (geometric.empty() || !factor) return false;
  const bool is_large = is_sparse(information);
  const auto spectrum =
      bordered_spectrum(information(geometric, geometric), own_places(model, geometric),
                        is_large ? kNoDigits : kFewDigits);
  if (!spectrum && !is_large) return false;
  result.rank = static_cast<int>(factor->rank());
  if (!spectrum) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    set_condition({1, 0, 0, kInfinite}, model.rows(), result);
    return true;
  }
  const double sigma = model.sigma().position;
  set_condition(
      {sigma * std::sqrt(spectrum->largest), sigma * std::sqrt(spectrum->smallest),
       sigma * std::exp(0.5 * spectrum->mean_log), spectrum->sum_of_inverse_roots / sigma},
      model.rows(), result);
  return true;
}

// Rank of all unknowns, coefficients too; condition and observability of the geometric ones.
void set_observability(const SessionModels& model, const std::vector<GroupFold>& folds,
                       const Eigen::MatrixXd& information, CalibrationResult& result) {
  const int p = model.unknowns();
  if (model.groups() > 1 && set_observability_by_group(model, information, result)) return;
  const Eigen::MatrixXd factor = joint_factor(model, folds);
  // Columns of unit length, whatever their units.
  const Eigen::MatrixXd triangle = factor.topLeftCorner(p, p);
  const Eigen::VectorXd length = triangle.colwise().norm().transpose().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> columns;
  columns.setThreshold(1e-10);
  columns.compute(triangle * length.cwiseInverse().asDiagonal());
  result.rank = static_cast<int>(columns.rank());

  const std::vector<int> geometric = model.geometric_unknowns();
  if (!geometric.empty())
    set_condition(summed_up(model.sigma().position *
                            Eigen::JacobiSVD<Eigen::MatrixXd>(factor(Eigen::seqN(0, p), geometric))
                                .singularValues()),
                  model.rows(), result);
}

}  // namespace

void set_statistics(const SessionModels& model, const ReadingLaw& law, const Priors& all_priors,
                    const Eigen::VectorXd& x, std::vector<GroupFold> folds,
                    FitStatistics statistics, CalibrationResult& result) {
  const std::vector<Prior>& priors = all_priors.of_unknowns;
  const int p = model.unknowns();
  folds = folds_at(model, law, x, std::move(folds));
  const Eigen::MatrixXd information = joint_information(model, folds);
  const Eigen::Array2d determined = determined_by(model, information, all_priors, x);
  result.determined = {determined[0], determined[1]};
  InverseRoot root(model, information, priors);
  result.inverse_root =
      root.sparse.size() > 0 ? Eigen::MatrixXd(root.sparse) : std::move(root.dense);
  result.prior_weight = result.prior_residual = Eigen::VectorXd::Zero(p);
  result.share_of_readings = Eigen::VectorXd::Ones(p);
  for (const Prior& prior : priors) {
    result.prior_weight[prior.unknown] = 1.0 / prior.deviation;
    result.prior_residual[prior.unknown] = -prior.residual(x);
    // Exactly zero, without rounding, for an unknown that moves no reading.
    if (information(prior.unknown, prior.unknown) == 0) {
      result.share_of_readings[prior.unknown] = 0;
      continue;
    }
    result.share_of_readings[prior.unknown] =
        std::clamp(1 - result.inverse_root.row(prior.unknown).squaredNorm() /
                           (prior.deviation * prior.deviation),
                   0.0, 1.0);
  }
  result.names = model.unknown_names();
  result.shared = model.first_own(1);
  const double variance = set_weights(model, law, x, result);
  if (statistics == FitStatistics::information) return;
  const std::optional<SingleNumbers> single =
      single_numbers(model, all_priors, result.share_of_readings, model.rows() - determined[0]);
  const auto covariance = [&](const auto& any_root) {
    return covariance_by_pose(model, priors, x, result.weights, result.degrees_of_freedom, any_root,
                              variance, single);
  };
  result.covariance =
      root.sparse.size() > 0 ? covariance(root.sparse) : covariance(result.inverse_root);
  set_observability(model, folds, information, result);
}

void set_weights_alone(const SessionModels& model, const ReadingLaw& law, const Priors& priors,
                       const Eigen::VectorXd& x, const std::vector<GroupFold>& folds,
                       CalibrationResult& result) {
  const Eigen::Array2d determined =
      determined_by(model, joint_information(model, folds), priors, x);
  result.determined = {determined[0], determined[1]};
  result.names = model.unknown_names();
  result.shared = model.first_own(1);
  set_weights(model, law, x, result);
}

std::array<double, 5> observability(const Eigen::VectorXd& s, int readings) {
  return observability(summed_up(s), readings);
}

}  // namespace armtrue
