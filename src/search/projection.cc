#include "search/projection.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
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
      parts_{ValuesAtRows(scan.parts_[CandidateScan::kPosture], fit.replicates()),
             ValuesAtRows(scan.parts_[CandidateScan::kVisit], fit.replicates())},
      on_basis_(fit.basis().cols(), scan.value_of_column_.size()),
      slopes_(scan.value_of_column_.size()),
      squared_norms_(scan.candidates_.size()),
      grams_(scan.candidates_.size()),
      solutions_(scan.candidates_.size()) {
  project_columns();
}

Eigen::VectorXd ProjectedCandidates::squares_by_context(int parameter,
                                                        const ValuesAtRows& values) const {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(values.values().rows());
  for (int row = 0; row < fit_.rows(); ++row)
    squares[values.context_of_row(row)] += fit_.jacobian()
                                               .col(parameter)
                                               .segment(row * fit_.row_size(), fit_.row_size())
                                               .squaredNorm();
  return squares;
}

void ProjectedCandidates::project_columns() {
  // Transposed once, so that the numbers of a row lie side by side in memory.
  const Eigen::Index rank = fit_.basis().cols();
  RowMajor<double> by_row(fit_.basis().rows(), rank + 1);
  by_row << fit_.basis(), fit_.residual();
  for_each_product(by_row, [&](const SomeColumns& some, const auto& products) {
    on_basis_.middleCols(some.first, some.count) = products.topRows(rank);
    auto slopes = slopes_.segment(some.first, some.count);
    slopes = products.row(rank).transpose();
    for (int k = 0; k < some.count && some.values.differ(); ++k)
      slopes[k] +=
          fit_.jacobian()
              .col(some.parameter)
              .dot(some.values.pulls().col(scan_.value_of_column_[some.first + k]).cast<double>());
  });
  find_spreads();
  compute_grams();
}

// Of the pairs of values that have columns in one candidate.
void ProjectedCandidates::find_spreads() {
  std::array<std::set<std::pair<int, int>>, CandidateScan::kParts> pairs;
  for (size_t candidate = 0; candidate < scan_.candidates_.size(); ++candidate) {
    const size_t part = scan_.part_[candidate];
    if (!parts_[part].differ()) continue;
    const auto& terms = scan_.terms_[candidate];
    for (const auto& a : terms)
      for (const auto& b : terms)
        if (a.coefficient <= b.coefficient)
          pairs[part].insert(
              std::minmax(scan_.value_of_column_[a.column], scan_.value_of_column_[b.column]));
  }
  for (size_t part = 0; part < parts_.size(); ++part) parts_[part].find_spreads(pairs[part]);
}

// Adds the products of the rests of the columns.
void ProjectedCandidates::add_spreads(int candidate, Eigen::MatrixXd& gram) const {
  const auto& terms = scan_.terms_[candidate];
  const int size = fit_.row_size();
  for (const auto& a : terms)
    for (const auto& b : terms) {
      if (a.coefficient > b.coefficient) continue;
      const auto [u, v] =
          std::minmax(scan_.value_of_column_[a.column], scan_.value_of_column_[b.column]);
      const Eigen::VectorXd& spread = values_of(candidate).spread(u, v);
      double sum = 0;
      for (int row = 0; row < fit_.rows(); ++row)
        sum += spread[row] * fit_.jacobian()
                                 .col(a.parameter)
                                 .segment(row * size, size)
                                 .dot(fit_.jacobian().col(b.parameter).segment(row * size, size));
      gram(a.coefficient, b.coefficient) += sum;
      if (a.coefficient < b.coefficient) gram(b.coefficient, a.coefficient) += sum;
    }
}

Eigen::MatrixXd ProjectedCandidates::columns(int candidate) const {
  const ValuesAtRows& of_part = values_of(candidate);
  const int size = fit_.row_size();
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(fit_.rows() * size, scan_.coefficient_count_[candidate]);
  for (const auto& term : scan_.terms_[candidate]) {
    const auto values = of_part.values().col(scan_.value_of_column_[term.column]);
    for (int row = 0; row < fit_.rows(); ++row)
      columns.col(term.coefficient).segment(row * size, size) +=
          static_cast<double>(values[of_part.context_of_row(row)]) *
          fit_.jacobian().col(term.parameter).segment(row * size, size);
  }
  return columns;
}

// The rests of the columns, see Directions.
Eigen::MatrixXd ProjectedCandidates::rests(int candidate) const {
  const ValuesAtRows& of_part = values_of(candidate);
  const Replicates& replicates = fit_.replicates();
  const int size = fit_.row_size();
  Eigen::MatrixXd rests = Eigen::MatrixXd::Zero(of_part.differ() ? replicates.readings() * size : 0,
                                                scan_.coefficient_count_[candidate]);
  if (!of_part.differ()) return rests;
  for (const auto& term : scan_.terms_[candidate]) {
    const int value = scan_.value_of_column_[term.column];
    for (int row = 0; row < fit_.rows(); ++row)
      for (int k = replicates.first[row]; k < replicates.first[row + 1]; ++k)
        rests.col(term.coefficient).segment(k * size, size) +=
            replicates.share[k] * of_part.beside_mean(row, k, value) *
            fit_.jacobian().col(term.parameter).segment(row * size, size);
  }
  return rests;
}

// X^T X of one candidate, from the squared norms of the derivatives at each context.
Eigen::MatrixXd ProjectedCandidates::gram_of(int candidate, const Squares& squares) const {
  const auto& terms = scan_.terms_[candidate];
  const ValuesAtRows& of_part = values_of(candidate);
  const bool one_parameter = std::all_of(terms.begin(), terms.end(), [&](const auto& term) {
    return term.parameter == terms.front().parameter;
  });
  if (!one_parameter) {
    const Eigen::MatrixXd whole = columns(candidate);
    return whole.transpose() * whole;
  }
  const Eigen::VectorXd& own = squares[terms.front().parameter][scan_.part_[candidate]];
  const auto values_at = [&](const auto& term) {
    return of_part.values().col(scan_.value_of_column_[term.column]).template cast<double>();
  };
  const int count = scan_.coefficient_count_[candidate];
  constexpr int kMostOfPlainProduct = 4;  // too few for a blocked product
  if (count <= kMostOfPlainProduct) {
    Eigen::MatrixXd gram(count, count);
    for (const auto& a : terms)
      for (const auto& b : terms)
        if (a.coefficient <= b.coefficient)
          gram(a.coefficient, b.coefficient) = gram(b.coefficient, a.coefficient) =
              own.cwiseProduct(values_at(a)).dot(values_at(b));
    return gram;
  }
  Eigen::MatrixXd values(of_part.values().rows(), count);
  for (const auto& term : terms) values.col(term.coefficient) = values_at(term);
  return values.transpose() * (own.asDiagonal() * values);
}

void ProjectedCandidates::compute_grams() {
  Squares squares(scan_.parameters());
  for (int parameter = 0; parameter < scan_.parameters(); ++parameter)
    for (size_t part = 0; part < parts_.size(); ++part)
      squares[parameter][part] = squares_by_context(parameter, parts_[part]);
  for_ordered_blocks<int>(
      static_cast<int>(scan_.candidates_.size()), kCandidatesPerBlock,
      [&](int begin, int end) {
        for (int candidate = begin; candidate < end; ++candidate) {
          Eigen::MatrixXd gram = gram_of(candidate, squares);
          if (values_of(candidate).differ()) add_spreads(candidate, gram);
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
  const auto whitened = [&](const Eigen::MatrixXd& scaled) -> Solution {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    const auto& values = eigen.eigenvalues();  // smallest first
    const auto rank = (values.array() > smallest * values[k - 1]).count();
    return {values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal() *
                eigen.eigenvectors().rightCols(rank).transpose() * unit.asDiagonal(),
            static_cast<int>(rank), largest_share};
  };
  const auto solution = [&]<typename Matrix>(const Matrix& scaled) -> Solution {
    // Cholesky's factor L whitens too, for less, where no direction is to be left out: the least
    // eigenvalue is at least 1 / |L^-1|^2, the largest at most the trace.
    if (const Eigen::LLT<Matrix> llt(scaled); llt.info() == Eigen::Success) {
      Matrix inverse = Matrix::Identity(k, k);
      llt.matrixL().solveInPlace(inverse);
      if (smallest * scaled.trace() * inverse.squaredNorm() < 1)
        return {inverse * unit.asDiagonal(), static_cast<int>(k), largest_share};
    }
    return whitened(scaled);
  };
  if (k == 2)  // most candidates: cycles
    return solution(Eigen::Matrix2d(unit.asDiagonal() * gram * unit.asDiagonal()));
  return solution(Eigen::MatrixXd(unit.asDiagonal() * gram * unit.asDiagonal()));
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

// Without some effects the columns X2 are longer, by their part Y in the directions that only those
// effects span. So with the slope s beside the rest, the Gram matrix beside the whole model bounds
// the gain from above,
//     s^T (X2^T X2 + Y^T Y)^-1 s <= s^T (X2^T X2)^-1 s.
double ProjectedCandidates::most_gain(int candidate, const Eigen::VectorXd& slope) const {
  const Solution& solution = solutions_[candidate];
  if (solution.degrees_of_freedom < slope.size())  // no bound in what is left out
    return std::numeric_limits<double>::infinity();
  return (solution.whitening * slope).squaredNorm();
}

// The charge is at least that of one direction.
bool ProjectedCandidates::can_exceed(double least, int candidate, const Eigen::VectorXd& slope,
                                     double norm) const {
  const double most = most_gain(candidate, slope);
  if (most == std::numeric_limits<double>::infinity()) return true;
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
    lost.col(k) = places[k].loss.span * places[k].loss.residual;
  }
  // Contribution of the losses to the slopes: X^T (Q span) (its residual).
  const Eigen::MatrixXd slopes = on_basis_.transpose() * lost;
  for (size_t k = 0; k < effects.size(); ++k) places[k].slopes = slopes.col(k);
  return places;
}

ProjectedCandidates::InPlace ProjectedCandidates::in_place(double least, double least_imitation,
                                                           const Asked& asked,
                                                           const Place& place) const {
  const bool with_imitations = least_imitation < kNoImitation;
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
          const auto can_imitate = [&] {
            return with_imitations && most_gain(candidate, slope_of(candidate, place.slopes)) >=
                                          least_imitation * lost;
          };
          if (!(can_exceed(least, candidate, slope, norm) || can_imitate()) ||
              (asked && !asked(candidate))) {
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
  for (int candidate = 0; candidate < static_cast<int>(solutions_.size()); ++candidate) {
    CandidateScore& own = scores.emplace_back(score(
        candidate, solutions_[candidate], slope_of(candidate, slopes_), fit_.residual_norm()));
    if (take_nearly_all(own.degrees_of_freedom))
      own.score = -std::numeric_limits<double>::infinity();
  }
  return scores;
}

ProjectedCandidates::InPlace ProjectedCandidates::in_place_of(int effect, double least,
                                                              double least_imitation) const {
  const Place place = places_of({{effect}}).front();
  const double whole = std::max(1e-300, place.loss.residual.squaredNorm());
  InPlace result = in_place(least, least_imitation, {}, place);
  for (CandidateScore& one : result.imitations) one.gain = std::clamp(one.gain / whole, 0.0, 1.0);
  return result;
}

Directions ProjectedCandidates::directions(int candidate) const {
  const Eigen::MatrixXd own = columns(candidate) - fit_.basis() * on_basis(candidate);
  const Eigen::MatrixXd whitening = solutions_[candidate].whitening.transpose();
  return {own * whitening, rests(candidate) * whitening};
}

}  // namespace armtrue
