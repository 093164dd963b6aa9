#include "search/projection.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

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

CandidateScore score_of(const Linearization& fit, const Linearization::Loss& loss, bool shrunken,
                        double log_choices) {
  CandidateScore score;
  score.degrees_of_freedom = static_cast<int>(loss.span.cols());
  score.gain = loss.residual.squaredNorm();
  score.score = ebic_fall(shrunken, log_choices, score.degrees_of_freedom, score.gain,
                          fit.residual_norm() + score.gain, fit.residual_freedom());
  return score;
}

ProjectedCandidates::ProjectedCandidates(const CandidateScan& scan, const Linearization& fit)
    : scan_(scan),
      fit_(fit),
      on_basis_(fit.basis().cols(), static_cast<int>(scan.value_of_column_.size())),
      slopes_(static_cast<int>(scan.value_of_column_.size())),
      squared_norms_(scan.candidates_.size()),
      grams_(scan.candidates_.size()),
      solutions_(scan.candidates_.size()) {
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

// X^T X of one candidate, from the squared norms of the derivatives at each context.
Eigen::MatrixXd ProjectedCandidates::gram_of(int candidate,
                                             const std::vector<Eigen::VectorXd>& squares) const {
  const auto& terms = scan_.terms_[candidate];
  const bool one_parameter = std::all_of(terms.begin(), terms.end(), [&](const auto& term) {
    return term.parameter == terms.front().parameter;
  });
  if (!one_parameter) {
    const Eigen::MatrixXd whole = scan_.columns(fit_, candidate);
    return whole.transpose() * whole;
  }
  Eigen::MatrixXd values(scan_.values_.rows(), scan_.coefficient_count_[candidate]);
  for (const auto& term : terms)
    values.col(term.coefficient) =
        scan_.values_.col(scan_.value_of_column_[term.column]).cast<double>();
  const Eigen::MatrixXd weighted = squares[terms.front().parameter].asDiagonal() * values;
  constexpr Eigen::Index kFew = 4;  // too few for a blocked product
  if (values.cols() <= kFew) return values.transpose().lazyProduct(weighted);
  return values.transpose() * weighted;
}

void ProjectedCandidates::compute_grams(const std::vector<Eigen::VectorXd>& squares) {
  for_ordered_blocks<int>(
      static_cast<int>(scan_.candidates_.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          Eigen::MatrixXd gram = gram_of(candidate, squares);
          squared_norms_[candidate] = gram.diagonal();
          const Eigen::MatrixXd projected = on_basis(candidate);
          gram.noalias() -= projected.transpose() * projected;
          solutions_[candidate] = solve(candidate, gram);
          grams_[candidate] = std::move(gram);
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

// Of the coefficients of a candidate, from those of the columns.
Eigen::VectorXd ProjectedCandidates::slope_of(int candidate,
                                              const Eigen::VectorXd& of_columns) const {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(scan_.coefficient_count_[candidate]);
  for (const auto& term : scan_.terms_[candidate])
    slope[term.coefficient] += of_columns[term.column];
  return slope;
}

ProjectedCandidates::Solution ProjectedCandidates::solve(int candidate,
                                                         const Eigen::MatrixXd& gram) const {
  const Eigen::Index k = gram.cols();
  const Eigen::VectorXd& own = squared_norms_[candidate];

  // Principal directions of the columns X2, each scaled to unit length.
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(k);
  double largest_share = 0;
  for (Eigen::Index c = 0; c < k; ++c) {
    if (own[c] <= kMinColumnNorm * kMinColumnNorm) continue;
    const double share = std::sqrt(std::max(0.0, gram(c, c)) / own[c]);
    largest_share = std::max(largest_share, share);
    if (share >= kMinUnexplainedShare) unit[c] = 1 / std::sqrt(gram(c, c));
  }
  if (k == 1)
    return {Eigen::MatrixXd::Constant(unit[0] > 0, 1, unit[0]), unit[0] > 0, largest_share};
  const double smallest =
      scan_.candidates_[candidate].fine ? kMinDirectionOfFineCurve : kMinDirection;
  const auto whitened = [&](const auto& eigen) -> Solution {
    const auto& values = eigen.eigenvalues();  // smallest first
    const auto rank = (values.array() > smallest * values[k - 1]).count();
    return {values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
                eigen.eigenvectors().rightCols(rank).transpose() * unit.asDiagonal(),
            static_cast<int>(rank), largest_share};
  };
  if (k == 2)  // most candidates: cycles
    return whitened(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(
        Eigen::Matrix2d(unit.asDiagonal() * gram * unit.asDiagonal())));
  return whitened(
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(unit.asDiagonal() * gram * unit.asDiagonal()));
}

// `norm`: |r|^2 before the candidate enters.
CandidateScore ProjectedCandidates::score(int candidate, const Solution& solution,
                                          const Eigen::VectorXd& slope, double norm) const {
  CandidateScore score;
  score.degrees_of_freedom = solution.degrees_of_freedom;
  score.unexplained_share = solution.unexplained_share;
  const Eigen::VectorXd whitened = solution.whitening * slope;
  score.coefficients = solution.whitening.transpose() * whitened;
  score.gain = whitened.squaredNorm();
  const Candidate& of = scan_.candidates_[candidate];
  score.score = ebic_fall(is_shrunken(of.effect), of.log_choices, score.degrees_of_freedom,
                          score.gain, norm, fit_.residual_freedom());
  return score;
}

// Without some effects the columns X2 are longer: to what they have beside the whole model comes
// what only those effects span. So with the slope s beside the rest, the Gram matrix beside the
// whole model bounds the gain from above,
//     s^T (X2^T X2 + Y^T Y)^-1 s <= s^T (X2^T X2)^-1 s,
// and the charge is at least that of one direction.
bool ProjectedCandidates::can_exceed(double least, int candidate, const Eigen::VectorXd& slope,
                                     double norm) const {
  const Solution& solution = solutions_[candidate];
  if (solution.degrees_of_freedom < slope.size()) return true;  // no bound in what is left out
  const double most = (solution.whitening * slope).squaredNorm();
  const Candidate& of = scan_.candidates_[candidate];
  return ebic_fall(is_shrunken(of.effect), of.log_choices, 1, std::min(most, norm), norm,
                   fit_.residual_freedom()) > least;
}

std::vector<ProjectedCandidates::Place> ProjectedCandidates::places_of(
    const std::vector<std::vector<int>>& effects) const {
  std::vector<Place> places(effects.size());
  Eigen::MatrixXd lost(on_basis_.rows(), std::ssize(effects));
  for (size_t k = 0; k < effects.size(); ++k) {
    places[k].loss = fit_.without(effects[k]);
    lost.col(static_cast<Eigen::Index>(k)) = places[k].loss.span * places[k].loss.residual;
  }
  // What the losses add to the slopes: X^T (Q span) (its residual).
  const Eigen::MatrixXd slopes = on_basis_.transpose() * lost;
  for (size_t k = 0; k < effects.size(); ++k)
    places[k].slopes = slopes.col(static_cast<Eigen::Index>(k));
  return places;
}

ProjectedCandidates::InPlace ProjectedCandidates::in_place(double least, const Place& place,
                                                           bool with_imitations) const {
  const Linearization::Loss& loss = place.loss;
  const double lost = loss.residual.squaredNorm(), norm = fit_.residual_norm() + lost;
  const Eigen::VectorXd slopes = slopes_ + place.slopes;
  const size_t count = scan_.candidates_.size();
  InPlace result{std::vector<CandidateScore>(count),
                 std::vector<CandidateScore>(with_imitations ? count : 0)};
  for_ordered_blocks<int>(
      static_cast<int>(count), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          const Eigen::VectorXd slope = slope_of(candidate, slopes);
          if (!can_exceed(least, candidate, slope, norm)) {
            result.scores[candidate].score = -std::numeric_limits<double>::infinity();
            continue;
          }
          const Eigen::MatrixXd returned = loss.span.transpose() * on_basis(candidate);
          const Solution solution =
              solve(candidate, grams_[candidate] + returned.transpose() * returned);
          result.scores[candidate] = score(candidate, solution, slope, norm);
          if (with_imitations)
            result.imitations[candidate] =
                score(candidate, solution, slope_of(candidate, place.slopes), lost);
        }
        return 0;
      },
      [](int) {});
  return result;
}

std::vector<CandidateScore> ProjectedCandidates::scores() const {
  std::vector<CandidateScore> scores;
  for (int candidate = 0; candidate < static_cast<int>(solutions_.size()); ++candidate)
    scores.push_back(score(candidate, solutions_[candidate], slope_of(candidate, slopes_),
                           fit_.residual_norm()));
  return scores;
}

ProjectedCandidates::InPlace ProjectedCandidates::in_place_of(int effect) const {
  const Place place = places_of({{effect}}).front();
  const double whole = std::max(1e-300, place.loss.residual.squaredNorm());
  InPlace result = in_place(-std::numeric_limits<double>::infinity(), place, true);
  for (CandidateScore& one : result.imitations) one.gain = std::clamp(one.gain / whole, 0.0, 1.0);
  return result;
}

Eigen::MatrixXd ProjectedCandidates::directions(int candidate) const {
  const Eigen::MatrixXd projected = on_basis(candidate);
  const Eigen::MatrixXd own = scan_.columns(fit_, candidate) - fit_.basis() * projected;
  return own * solutions_[candidate].whitening.transpose();
}

}  // namespace armtrue
