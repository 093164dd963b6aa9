#include "search/projection.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "linear_algebra/decompositions.h"
#include "search/ebic.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {
namespace {

// A smaller share of a column's norm after projection is rounding, not evidence.
constexpr double kMinUnexplainedShare = 1e-5;
// Principal directions of a candidate with a smaller squared share of the largest are left out. A
// fine curve always has weak directions, and their coefficients would take any value.
constexpr double kMinDirection = 1e-6, kMinDirectionOfFineCurve = 1e-4;
constexpr double kScoreTolerance = 0.01;  // of EBIC; less is rounding and the end of an iteration
constexpr int kColumnsPerBlock = 256;     // bounds the memory of one task

}  // namespace

std::vector<int> best_first(const std::vector<CandidateScore>& scores) {
  std::vector<int> order(scores.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::round(scores[a].score / kScoreTolerance) >
           std::round(scores[b].score / kScoreTolerance);
  });
  return order;
}

ProjectedCandidates::ProjectedCandidates(const CandidateScan& scan, const Linearization& fit)
    : scan_(scan),
      fit_(fit),
      on_basis_(fit.basis().cols(), static_cast<int>(scan.value_of_column_.size())),
      slopes_(static_cast<int>(scan.value_of_column_.size())),
      grams_(scan.candidates_.size()) {
  project_columns();
}

Eigen::VectorXd ProjectedCandidates::squares_by_context(int parameter) const {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(scan_.values_.rows());
  for (int row = 0; row < fit_.rows(); ++row)
    squares[scan_.context_of_row_[row]] += fit_.jacobian()
                                               .col(parameter)
                                               .segment(row * fit_.row_size(), fit_.row_size())
                                               .squaredNorm();
  return squares;
}

void ProjectedCandidates::project_columns() {
  const int contexts = static_cast<int>(scan_.values_.rows());
  // Transposed once, so that the numbers of a row lie side by side in memory.
  Eigen::MatrixXd target(fit_.basis().rows(), fit_.basis().cols() + 1);
  target << fit_.basis(), fit_.residual();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_row = target;
  std::vector<Eigen::VectorXd> squares(static_cast<size_t>(scan_.parameters()));
  for_ordered_blocks<int>(
      scan_.parameters(), 1,
      [&](int parameter, int) {
        const int first = scan_.first_column_[parameter];
        const int count = scan_.first_column_[parameter + 1] - first;
        if (count == 0) return 0;
        const Eigen::MatrixXd sums = sums_by_context(parameter, by_row);
        const Eigen::Index rank = fit_.basis().cols();
        for (int begin = 0; begin < count; begin += kColumnsPerBlock) {
          const int end = std::min(count, begin + kColumnsPerBlock);
          Eigen::MatrixXd values(contexts, end - begin);
          for (int k = begin; k < end; ++k)
            values.col(k - begin) =
                scan_.values_.col(scan_.value_of_column_[first + k]).cast<double>();
          on_basis_.middleCols(first + begin, end - begin).noalias() =
              sums.leftCols(rank).transpose() * values;
          slopes_.segment(first + begin, end - begin).noalias() =
              values.transpose() * sums.col(rank);
        }
        squares[parameter] = squares_by_context(parameter);
        return 0;
      },
      [](int) {});
  compute_grams(squares);
}

void ProjectedCandidates::compute_grams(const std::vector<Eigen::VectorXd>& squares) {
  for_ordered_blocks<int>(
      static_cast<int>(scan_.candidates_.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          const auto& terms = scan_.terms_[candidate];
          const bool one_parameter = std::all_of(terms.begin(), terms.end(), [&](const auto& term) {
            return term.parameter == terms.front().parameter;
          });
          if (!one_parameter) {
            const Eigen::MatrixXd whole = scan_.columns(fit_, candidate);
            grams_[candidate].noalias() = whole.transpose() * whole;
            continue;
          }
          Eigen::MatrixXd values(scan_.values_.rows(), scan_.coefficient_count_[candidate]);
          for (const auto& term : terms)
            values.col(term.coefficient) =
                scan_.values_.col(scan_.value_of_column_[term.column]).cast<double>();
          grams_[candidate].noalias() =
              values.transpose() * squares[terms.front().parameter].asDiagonal() * values;
        }
        return 0;
      },
      [](int) {});
}

Eigen::MatrixXd ProjectedCandidates::on_basis(int candidate) const {
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(on_basis_.rows(), scan_.coefficient_count_[candidate]);
  for (const auto& term : scan_.terms_[candidate])
    result.col(term.coefficient) += on_basis_.col(term.column);
  return result;
}

ProjectedCandidates::Solution ProjectedCandidates::solve(int candidate,
                                                         const Eigen::MatrixXd& projected,
                                                         const Eigen::MatrixXd& returned) const {
  const int k = scan_.coefficient_count_[candidate];
  Eigen::MatrixXd gram = grams_[candidate];
  const Eigen::VectorXd own = gram.diagonal();
  gram.noalias() -= projected.transpose() * projected;
  if (returned.size() > 0) gram.noalias() += returned.transpose() * returned;

  // Principal directions of the columns X2, each scaled to unit length.
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(k);
  double largest_share = 0;
  for (int c = 0; c < k; ++c) {
    if (own[c] <= kMinColumnNorm * kMinColumnNorm) continue;
    const double share = std::sqrt(std::max(0.0, gram(c, c)) / own[c]);
    largest_share = std::max(largest_share, share);
    if (share >= kMinUnexplainedShare) unit[c] = 1 / std::sqrt(gram(c, c));
  }
  if (k == 1)
    return {Eigen::MatrixXd::Constant(unit[0] > 0, 1, unit[0]), unit[0] > 0, largest_share};
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * gram *
                                                             unit.asDiagonal());
  const Eigen::VectorXd& values = eigen.eigenvalues();  // smallest first
  const double smallest =
      scan_.candidates_[candidate].fine ? kMinDirectionOfFineCurve : kMinDirection;
  const auto rank = (values.array() > smallest * values[k - 1]).count();
  return {values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
              eigen.eigenvectors().rightCols(rank).transpose() * unit.asDiagonal(),
          static_cast<int>(rank), largest_share};
}

std::vector<CandidateScore> ProjectedCandidates::scores(const Linearization::Loss& loss,
                                                        bool with_residual) const {
  const double norm = (with_residual ? fit_.residual_norm() : 0.0) + loss.residual.squaredNorm();
  std::vector<CandidateScore> scores(scan_.candidates_.size());
  for_ordered_blocks<int>(
      static_cast<int>(scores.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          const Eigen::MatrixXd projected = on_basis(candidate);
          const Eigen::MatrixXd returned = loss.span.transpose() * projected;
          const Solution solution = solve(candidate, projected, returned);
          Eigen::VectorXd slope = returned.transpose() * loss.residual;
          if (with_residual)
            for (const auto& term : scan_.terms_[candidate])
              slope[term.coefficient] += slopes_[term.column];
          CandidateScore& score = scores[candidate];
          score.degrees_of_freedom = solution.degrees_of_freedom;
          score.unexplained_share = solution.unexplained_share;
          const Eigen::VectorXd whitened = solution.whitening * slope;
          score.coefficients = solution.whitening.transpose() * whitened;
          score.gain = whitened.squaredNorm();
          const Candidate& of = scan_.candidates_[candidate];
          score.score = ebic_fall(is_shrunken(of.effect), of.log_choices, score.degrees_of_freedom,
                                  score.gain, norm, fit_.residual_freedom());
        }
        return 0;
      },
      [](int) {});
  return scores;
}

std::vector<CandidateScore> ProjectedCandidates::scores() const {
  return scores({Eigen::MatrixXd(fit_.basis().cols(), 0), Eigen::VectorXd(0)}, true);
}

std::vector<CandidateScore> ProjectedCandidates::scores_without(
    const std::vector<int>& effects) const {
  return scores(fit_.without(effects), true);
}

std::vector<CandidateScore> ProjectedCandidates::imitations(int effect) const {
  const Linearization::Loss loss = fit_.without({effect});
  const double whole = std::max(1e-300, loss.residual.squaredNorm());
  std::vector<CandidateScore> imitations = scores(loss, false);
  for (CandidateScore& one : imitations) one.gain = std::clamp(one.gain / whole, 0.0, 1.0);
  return imitations;
}

Eigen::MatrixXd ProjectedCandidates::directions(int candidate) const {
  const Eigen::MatrixXd projected = on_basis(candidate);
  const Eigen::MatrixXd own = scan_.columns(fit_, candidate) - fit_.basis() * projected;
  return own * solve(candidate, projected, {}).whitening.transpose();
}

CandidateScore ProjectedCandidates::score_of(const std::vector<int>& effects, bool shrunken,
                                             double log_choices) const {
  const Linearization::Loss loss = fit_.without(effects);
  CandidateScore score;
  score.degrees_of_freedom = static_cast<int>(loss.span.cols());
  score.gain = loss.residual.squaredNorm();
  score.score = ebic_fall(shrunken, log_choices, score.degrees_of_freedom, score.gain,
                          fit_.residual_norm() + score.gain, fit_.residual_freedom());
  return score;
}

}  // namespace armtrue
