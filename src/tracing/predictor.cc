#include "tracing/predictor.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "armtrue/statistics/distributions.h"
#include "calibration/session_models.h"
#include "campaign/selection.h"
#include "campaign/sessions.h"
#include "linear_algebra/decompositions.h"
#include "search/candidates.h"
#include "search/projection.h"
#include "search/scan.h"
#include "search/significance.h"
#include "statistics/ordered_blocks.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

using Rows = std::vector<Eigen::Index>;

// More equations would improve the choice, but time and memory grow in proportion.
constexpr int kMaxEquations = 6000;
constexpr int kChoiceFolds = 5;
// The penalty falls in small steps from the value at which nothing enters, down to 1e-5 of that, or
// until kPatience steps in a row predict no better.
constexpr float kFall = 0.75f;
constexpr int kMaxPenalties = 40, kPatience = 3;
constexpr float kMinBeside = 0.01f;  // share of a column's norm that the model cannot imitate
constexpr double kMinPoses = 8;      // poses that determine a column
// Level of one standard error: with a clear lack of fit, the gain need not show again that
// something is missing.
constexpr double kSignificanceWithLackOfFit = 0.16;
// Coordinate descent ends when the changes of gradients are below this share of the penalty, or
// after kMaxSweeps, when candidates that imitate each other only exchange their weights.
constexpr float kTolerance = 1e-2f;
constexpr int kMaxSweeps = 100;

// Whitened equations of a fit: residual, columns of its unknowns, and those of all candidates, which
// are made when they are needed: all of them together would fill the memory.
struct Equations {
  const CandidateScan& scan;
  Linearization linear;
  std::vector<Eigen::Index> first_column;  // of each candidate, and one past
  Eigen::MatrixXd model;                   // equations x unknowns
  Eigen::VectorXd residual;
  Eigen::MatrixXd prior;  // x unknowns: what was known beforehand
  Eigen::VectorXd prior_residual;
  std::vector<int> pose;  // of each row of the campaign
  int row_size;

  Equations(const CandidateScan& candidates, const CalibrationResult& fit,
            const Campaign& campaign)
      : scan(candidates), linear(fit, campaign), first_column{0} {
    const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
    Eigen::MatrixXd blocks = models.blocks();
    row_size = models.row_size();
    for (int row = 0; row < campaign.rows(); ++row)
      blocks.middleRows(row * row_size, row_size) *= std::sqrt(fit.weights[row]);
    model = blocks.leftCols(models.unknowns());
    residual = blocks.rightCols<1>();
    pose = campaign.pose_by_id();
    Rows known;
    for (Eigen::Index k = 0; k < fit.prior_weight.size(); ++k)
      if (fit.prior_weight[k] > 0) known.push_back(k);
    prior = Eigen::MatrixXd(fit.prior_weight.asDiagonal())(known, Eigen::all);
    prior_residual = fit.prior_residual(known);
    for (int k = 0; k < count(); ++k)
      first_column.push_back(first_column.back() + scan.coefficient_count(k));
  }

  int count() const { return static_cast<int>(scan.candidates().size()); }
  Eigen::Index columns() const { return first_column.back(); }
  Eigen::MatrixXf columns_of(int candidate) const {
    return scan.columns_at_readings(linear, candidate).cast<float>();
  }
  Eigen::VectorXf column(Eigen::Index j) const {
    const auto next = std::ranges::upper_bound(first_column, j);
    const auto candidate = static_cast<int>(next - first_column.begin()) - 1;
    return columns_of(candidate).col(j - first_column[static_cast<size_t>(candidate)]);
  }
};

// The lasso beside the model, from each penalty to the next lower one, by coordinate descent on the
// weights that are not zero or whose gradient exceeds the penalty.
class Lasso {
 public:
  Lasso(const Equations& all, const Rows& rows)
      : all_(all), rows_(rows), model_(with_prior(all.model(rows, Eigen::all), all.prior)) {
    basis_ = Eigen::MatrixXd(model_.householderQ() *
                             Eigen::MatrixXd::Identity(model_.rows(), model_.rank()))
                 .cast<float>();
    length_.resize(all.columns());
    for_ordered_blocks<int>(
        all.count(), kCandidatesPerBlock,
        [&](int begin, int end) {
          set_lengths(begin, end);
          return 0;
        },
        [](int) {});
    left_ = residual().cast<float>();
    left_ -= basis_ * (basis_.transpose() * left_);
    set_pull();
    unit_weights_ = Eigen::VectorXf::Zero(all.columns());
    is_active_.resize(static_cast<size_t>(all.columns()));
  }

  // The smallest penalty at which all weights are zero.
  float highest() const { return pull_.cwiseAbs().maxCoeff(); }

  void solve(float penalty) {
    for (bool grown = true; grown;) {
      grown = false;
      for (Eigen::Index j = 0; j < pull_.size(); ++j)
        if (!is_active_[j] && std::abs(pull_[j]) > penalty) {
          add(j);
          grown = true;
        }
      float change = penalty;
      for (int sweep = 0; sweep < kMaxSweeps && change > kTolerance * penalty; ++sweep) {
        change = 0;
        for (const Active& own : active_) {
          const float to_fit = own.unit.dot(left_) + unit_weights_[own.column];
          const float to = std::copysign(std::max(std::abs(to_fit) - penalty, 0.0f), to_fit);
          const float step = to - unit_weights_[own.column];
          if (step == 0) continue;
          left_ -= step * own.unit;
          unit_weights_[own.column] = to;
          change = std::max(change, std::abs(step));
        }
      }
      set_pull();
    }
  }

  Eigen::VectorXf weights() const { return unit_weights_.cwiseQuotient(length_); }

  // The residual of other rows, with the model refitted to the weights.
  Eigen::VectorXd left_of(const Rows& others) const {
    Eigen::VectorXf taken = Eigen::VectorXf::Zero(all_.residual.size());
    for (const Active& own : active_)
      if (unit_weights_[own.column] != 0)
        taken += unit_weights_[own.column] / length_[own.column] * own.whole;
    const Eigen::VectorXd left = all_.residual - taken.cast<double>();
    Eigen::VectorXd own = residual();
    own.head(static_cast<Eigen::Index>(rows_.size())) = left(rows_);
    return left(others) - all_.model(others, Eigen::all) * model_.solve(own);
  }

 private:
  struct Active {
    Eigen::Index column;
    Eigen::VectorXf whole, unit;  // at all rows; beside the model at these, of unit length
  };

  static Eigen::MatrixXd with_prior(const Eigen::MatrixXd& model, const Eigen::MatrixXd& prior) {
    Eigen::MatrixXd both(model.rows() + prior.rows(), model.cols());
    both << model, prior;
    return both;
  }

  Eigen::VectorXd residual() const {
    Eigen::VectorXd both(model_.rows());
    both << all_.residual(rows_), all_.prior_residual;
    return both;
  }

  // What the model cannot imitate of columns at these rows.
  Eigen::MatrixXf beside(const Eigen::MatrixXf& columns) const {
    const auto equations = static_cast<Eigen::Index>(rows_.size());
    Eigen::MatrixXf x = Eigen::MatrixXf::Zero(model_.rows(), columns.cols());
    x.topRows(equations) = columns(rows_, Eigen::all);
    x.noalias() -= basis_ * (basis_.topRows(equations).transpose() * x.topRows(equations));
    return x;
  }

  // Of the columns of some candidates; infinity of those that are left out.
  void set_lengths(int begin, int end) {
    const Eigen::Index first = all_.first_column[static_cast<size_t>(begin)];
    Eigen::MatrixXf columns(all_.residual.size(),
                            all_.first_column[static_cast<size_t>(end)] - first);
    for (int candidate = begin; candidate < end; ++candidate) {
      const Eigen::MatrixXf own = all_.columns_of(candidate);
      columns.middleCols(all_.first_column[static_cast<size_t>(candidate)] - first, own.cols()) =
          own;
    }
    const Eigen::MatrixXf x = beside(columns);
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      const float length = x.col(j).norm();
      const bool is_shown = length > kMinBeside * columns(rows_, j).norm() &&
                            poses_that_carry(x.col(j)) >= kMinPoses;
      length_[first + j] = is_shown ? length : std::numeric_limits<float>::infinity();
    }
  }

  void add(Eigen::Index j) {
    is_active_[j] = true;
    Eigen::VectorXf whole = all_.column(j);
    Eigen::VectorXf unit = beside(whole) / length_[j];
    active_.push_back({j, std::move(whole), std::move(unit)});
  }

  // What is left is orthogonal to the model, so the products are those of the columns beside it.
  void set_pull() {
    Eigen::VectorXd at_readings = Eigen::VectorXd::Zero(all_.residual.size());
    at_readings(rows_) = left_.head(static_cast<Eigen::Index>(rows_.size())).cast<double>();
    pull_ = all_.scan.products_at_readings(all_.linear, at_readings)
                .cast<float>()
                .cwiseQuotient(length_);
  }

  // Effective number of poses that determine a column (inverse participation ratio).
  double poses_that_carry(const Eigen::Ref<const Eigen::VectorXf>& column) const {
    std::vector<double> squares(1 + *std::max_element(all_.pose.begin(), all_.pose.end()));
    for (size_t k = 0; k < rows_.size(); ++k)
      squares[all_.pose[rows_[k] / all_.row_size]] +=
          std::pow(column[static_cast<Eigen::Index>(k)], 2);
    const Eigen::Map<const Eigen::VectorXd> of_pose(squares.data(), std::ssize(squares));
    return std::pow(of_pose.sum(), 2) / std::max(of_pose.squaredNorm(), 1e-300);
  }

  const Equations& all_;
  Rows rows_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> model_;
  Eigen::MatrixXf basis_;
  Eigen::VectorXf length_, left_, pull_, unit_weights_;
  std::vector<Active> active_;
  std::vector<bool> is_active_;
};

// Number of steps by which the penalty falls. 0 (all weights are zero) if the gain on the poses
// left out is not significant.
int best_falls(const Equations& all, float highest, std::uint64_t seed, double significance) {
  const int poses = 1 + *std::max_element(all.pose.begin(), all.pose.end());
  std::vector<int> order(poses), fold_of(poses);
  std::iota(order.begin(), order.end(), 0);
  shuffle(order, seed);
  for (int k = 0; k < poses; ++k) fold_of[order[k]] = k % kChoiceFolds;
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(poses, kMaxPenalties);  // squares
  for (int fold = 0; fold < kChoiceFolds; ++fold) {
    Rows in, out;
    for (size_t row = 0; row < all.pose.size(); ++row)
      for (int k = 0; k < all.row_size; ++k)
        (fold_of[all.pose[row]] == fold ? out : in)
            .push_back(static_cast<Eigen::Index>(row) * all.row_size + k);
    Lasso lasso(all, in);
    double least = std::numeric_limits<double>::infinity();
    Eigen::VectorXd squares;
    float penalty = highest;
    for (int falls = 0, since = 0; falls < kMaxPenalties; ++falls, penalty *= kFall) {
      if (since <= kPatience) {
        if (falls > 0) lasso.solve(penalty);
        squares = lasso.left_of(out).cwiseAbs2();
        since = squares.sum() < least ? 0 : since + 1;
        least = std::min(least, squares.sum());
      }
      for (size_t k = 0; k < out.size(); ++k)
        left(all.pose[out[k] / all.row_size], falls) += squares[static_cast<Eigen::Index>(k)];
    }
  }
  // Gain over the poses, in standard errors.
  const auto gain = [&](Eigen::Index from, Eigen::Index to) {
    const Eigen::VectorXd of_pose = left.col(from) - left.col(to);
    return of_pose.sum() / std::max((of_pose.array() - of_pose.mean()).matrix().norm(), 1e-300);
  };
  Eigen::Index best = 0, falls = 0;
  left.colwise().sum().minCoeff(&best);
  while (falls < best && gain(falls, best) > 1) ++falls;
  const bool is_significant =
      falls > 0 && student_t_above(gain(0, falls), std::max(1, poses - 1)) < significance;
  return is_significant ? static_cast<int>(falls) : 0;
}

}  // namespace

Robot with_remainder(const CalibrationResult& fit, const Campaign& campaign,
                     const Catalogue& catalogue, const TraceOptions& options) {
  std::vector<Candidate> candidates = catalogue_candidates(catalogue, fit.robot, campaign);
  if (options.beyond_catalogue)
    for (const Candidate& open : open_candidates(fit.robot, campaign)) candidates.push_back(open);
  std::erase_if(candidates, [](const Candidate& candidate) {
    return candidate.effect.driver.involves(DriverKind::time) ||
           is_polynomial(candidate.effect.shape);
  });
  const auto poses = static_cast<double>(campaign.pose_ids.size());
  const double equations = static_cast<double>(campaign.rows()) * campaign.reading_size().all();
  const std::vector<int> part_rows =
      rows_of_some_poses(campaign, std::lround(poses * std::min(1.0, kMaxEquations / equations)));
  const Campaign part = campaign.select(part_rows);
  CalibrationResult fit_of_part = fit;
  fit_of_part.weights.clear();
  for (int row : part_rows) fit_of_part.weights.push_back(fit.weights[row]);
  const CandidateScan scan(candidates, fit.robot, in_common_frame(part, fit.robot));
  const Equations all(scan, fit_of_part, part);
  Rows rows(all.residual.size());
  std::iota(rows.begin(), rows.end(), Eigen::Index{0});
  if (all.columns() == 0) return fit.robot;
  float penalty = Lasso(all, rows).highest();
  const int falls = best_falls(all, penalty, options.seed,
                               significance_level(fit, campaign, kSignificanceWithLackOfFit,
                                                  options.significance_without_lack_of_fit));
  if (falls == 0) return fit.robot;

  Lasso lasso(all, rows);
  for (int k = 0; k <= falls; ++k, penalty *= kFall) lasso.solve(penalty);
  const Eigen::VectorXf weights = lasso.weights();
  Robot robot = fit.robot;
  Eigen::Index column = 0;
  for (const Candidate& candidate : scan.candidates()) {
    Effect effect = candidate.effect;
    effect.name = kRemainder;
    effect.coefficients.clear();
    bool is_zero = true;
    const BoundEffect bound(effect, robot, campaign.temperature_names);
    for (const std::string& name : bound.coefficient_names()) {
      effect.coefficients.emplace_back().name = name;
      effect.coefficients.back().value = weights[column++];
      is_zero &= effect.coefficients.back().value == 0;
    }
    if (!is_zero) robot.effects.push_back(effect);
  }
  CalibrationOptions refit;
  refit.fitted_effects = static_cast<int>(fit.robot.effects.size());
  refit.start_near(fit);
  return calibrate(robot, campaign, fit.set, refit).robot;
}

}  // namespace armtrue
