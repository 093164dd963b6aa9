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
#include "search/scan.h"
#include "search/significance.h"
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

// Whitened equations of a fit: residual, columns of its unknowns, and columns of all candidates.
struct Equations {
  Eigen::MatrixXf columns;  // equations x columns, whitened
  Eigen::MatrixXd model;    // equations x unknowns
  Eigen::VectorXd residual;
  Eigen::MatrixXd prior;  // x unknowns: what was known beforehand
  Eigen::VectorXd prior_residual;
  std::vector<int> pose;  // of each row of the campaign
  int row_size;

  Equations(const CandidateScan& scan, const CalibrationResult& fit, const Campaign& campaign) {
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

    const Linearization linear(fit, campaign);
    const int count = static_cast<int>(scan.candidates().size());
    std::vector<Eigen::MatrixXf> of_candidate(count);
    Eigen::Index total = 0;
    for (int k = 0; k < count; ++k) {
      of_candidate[k] = scan.columns_at_readings(linear, k).cast<float>();
      total += of_candidate[k].cols();
    }
    columns.resize(blocks.rows(), total);
    Eigen::Index next = 0;
    for (Eigen::MatrixXf& own : of_candidate) {
      columns.middleCols(next, own.cols()) = own;
      next += own.cols();
      own.resize(0, 0);
    }
  }
};

// The lasso beside the model, from each penalty to the next lower one, by coordinate descent on the
// weights that are not zero or whose gradient exceeds the penalty.
class Lasso {
 public:
  Lasso(const Equations& all, const Rows& rows)
      : all_(all), rows_(rows), model_(with_prior(all.model(rows, Eigen::all), all.prior)) {
    const auto equations = static_cast<Eigen::Index>(rows.size());
    const Eigen::MatrixXf basis =
        Eigen::MatrixXd(model_.householderQ() *
                        Eigen::MatrixXd::Identity(model_.rows(), model_.rank()))
            .cast<float>();
    x_ = Eigen::MatrixXf::Zero(model_.rows(), all.columns.cols());
    x_.topRows(equations) = all.columns(rows, Eigen::all);
    length_ = x_.colwise().norm();
    x_.noalias() -= basis * (basis.topRows(equations).transpose() * x_.topRows(equations));
    for (Eigen::Index j = 0; j < x_.cols(); ++j) {
      const float beside = x_.col(j).norm();
      const bool is_shown =
          beside > kMinBeside * length_[j] && poses_that_carry(x_.col(j)) >= kMinPoses;
      length_[j] = is_shown ? beside : std::numeric_limits<float>::infinity();
      x_.col(j) /= length_[j];
    }
    left_ = residual().cast<float>();
    left_ -= basis * (basis.transpose() * left_);
    pull_ = x_.transpose() * left_;
    unit_weights_ = Eigen::VectorXf::Zero(x_.cols());
    is_active_.resize(x_.cols());
  }

  // The smallest penalty at which all weights are zero.
  float highest() const { return pull_.cwiseAbs().maxCoeff(); }

  void solve(float penalty) {
    for (bool grown = true; grown;) {
      grown = false;
      for (Eigen::Index j = 0; j < x_.cols(); ++j)
        if (!is_active_[j] && std::abs(pull_[j]) > penalty) {
          active_.push_back(j);
          is_active_[j] = grown = true;
        }
      float change = penalty;
      for (int sweep = 0; sweep < kMaxSweeps && change > kTolerance * penalty; ++sweep) {
        change = 0;
        for (Eigen::Index j : active_) {
          const float to_fit = x_.col(j).dot(left_) + unit_weights_[j];
          const float to = std::copysign(std::max(std::abs(to_fit) - penalty, 0.0f), to_fit);
          const float step = to - unit_weights_[j];
          if (step == 0) continue;
          left_ -= step * x_.col(j);
          unit_weights_[j] = to;
          change = std::max(change, std::abs(step));
        }
      }
      pull_.noalias() = x_.transpose() * left_;
    }
  }

  Eigen::VectorXf weights() const { return unit_weights_.cwiseQuotient(length_); }

  // The residual of other rows, with the model refitted to the weights.
  Eigen::VectorXd left_of(const Rows& others) const {
    Eigen::VectorXf taken = Eigen::VectorXf::Zero(all_.columns.rows());
    for (Eigen::Index j : active_)
      if (unit_weights_[j] != 0) taken += unit_weights_[j] / length_[j] * all_.columns.col(j);
    const Eigen::VectorXd left = all_.residual - taken.cast<double>();
    Eigen::VectorXd own = residual();
    own.head(static_cast<Eigen::Index>(rows_.size())) = left(rows_);
    return left(others) - all_.model(others, Eigen::all) * model_.solve(own);
  }

 private:
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
  Eigen::MatrixXf x_;  // of unit length, or of nothing
  Eigen::VectorXf length_, left_, pull_, unit_weights_;
  Rows active_;
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
  if (all.columns.cols() == 0) return fit.robot;
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
