#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "search/linearization.h"
#include "search/scan.h"
#include "search/values_at_rows.h"
#include "statistics/ordered_blocks.h"

namespace armtrue {

/// A whitened column with a smaller norm is rounding: its driver did not change.
inline constexpr double kMinColumnNorm = 1e-10;
/// Number of candidates of one task; the sums do not depend on it.
inline constexpr int kCandidatesPerBlock = 64;

/// Score of a candidate beside the model.
struct CandidateScore {
  int degrees_of_freedom = 0;    ///< independent columns left after projection; 0: not separable
  double unexplained_share = 0;  ///< largest share of a column's norm that the model cannot imitate
  double gain = 0;               ///< fall of the sum of squares of the whitened residuals
  double score = 0;              ///< ebic_fall(); positive: the model with it is better
  Eigen::VectorXd coefficients;
};

/// Score of some effects of a fit together beside the others. `loss`: that of the model without
/// them. `shrunken`: as of ebic_fall(); `log_choices` is the sum over the effects.
CandidateScore score_of(const Linearization& fit, const Linearization::Loss& loss, bool shrunken,
                        double log_choices);

/// Orthonormal columns: at the rows of a fit, and their rests at its replicates, row_size equations
/// of each in the order of Replicates::reading; no rests (0 rows) where those of a row do not
/// differ.
struct Directions {
  Eigen::MatrixXd at_rows, rests;
};

/// Indices of the scores, best first. Scores that differ by less than 0.01 keep their order.
std::vector<int> best_first(const std::vector<CandidateScore>& scores);

/// All candidates projected off the fitted columns of a model (Frisch, Waugh 1933; Lovell 1963).
/// For a candidate with columns X, basis Q and residual r:
///     X2 = X - Q Q^T X,  gain = |P r|^2,  P the projector on the columns of X2.
/// The products X2^T X2 = X^T X - (Q^T X)^T (Q^T X) come from Gram matrices, so that X2 itself
/// never exists. (Regression of r on the raw X would shrink the coefficients.)
class ProjectedCandidates {
 public:
  /// Keeps references to both arguments.
  ProjectedCandidates(const CandidateScan& scan, const Linearization& fit);

  /// Scores of each candidate beside everything in the model.
  std::vector<CandidateScore> scores() const;

  /// Whitened columns X of one candidate, before projection, at the rows of the fit:
  /// (rows * row_size) x coefficients.
  Eigen::MatrixXd columns(int candidate) const;

  /// Orthonormal basis of the columns X2 of one candidate.
  Directions directions(int candidate) const;

  /// Scores of each candidate in the place of some effects of the model.
  std::vector<CandidateScore> scores_without(const std::vector<int>& effects) const {
    return scores_above(-std::numeric_limits<double>::infinity(), effects);
  }

  /// The loss of the model without some effects, and the slopes of all columns with it.
  struct Place {
    Linearization::Loss loss;
    Eigen::VectorXd slopes;
  };
  /// The places of some effects, or of several together; all at once, because the products read
  /// Q^T X once.
  std::vector<Place> places_of(const std::vector<std::vector<int>>& effects) const;

  /// Numbers of candidates that are asked for; empty: all.
  using Asked = std::function<bool(int)>;

  /// The same where only scores above `least` count: candidates that are not asked for or cannot
  /// reach it, by an upper bound of their gain, are left at -infinity and cost next to nothing.
  std::vector<CandidateScore> scores_above(double least, const Place& place,
                                           const Asked& asked = {}) const {
    return in_place(least, kNoImitation, asked, place).scores;
  }
  std::vector<CandidateScore> scores_above(double least, const std::vector<int>& effects,
                                           const Asked& asked = {}) const {
    return scores_above(least, places_of({effects}).front(), asked);
  }

  /// Each candidate in the place of one effect of the model.
  struct InPlace {
    std::vector<CandidateScore> scores;  ///< as of scores_without()
    /// How well it imitates the effect. Both are projected off the rest of the model; `gain` is
    /// cos^2 of the angle between what the effect explains and the columns of the candidate,
    /// `coefficients` are those of the closest imitation.
    std::vector<CandidateScore> imitations;
  };
  /// Candidates whose score cannot exceed `least`, and of which cos^2 cannot reach
  /// `least_imitation`, are left at -infinity and no degree of freedom: see scores_above().
  InPlace in_place_of(int effect, double least = -std::numeric_limits<double>::infinity(),
                      double least_imitation = 0) const;

  /// Null distribution of the family-wise test: the best score of all candidates on residuals with
  /// random signs, one for each draw. All rows of a pose get the same sign, since they may share an
  /// error. The residual of pose i is first corrected for its leverage H_i,
  ///     (I - H_i)^(-1/2) r_i   (CR2; Bell, McCaffrey 2002),
  /// because the fit follows the readings of each pose, the more the fewer poses there are: draws
  /// of r itself would scatter too little.
  std::vector<double> best_of_flipped(int flips, std::uint64_t seed) const;

 private:
  // Orthonormalises the columns X2 of a candidate without the dependent ones:
  // whitening^T whitening is the (pseudo)inverse of their Gram matrix.
  struct Solution {
    Eigen::MatrixXd whitening;  // degrees of freedom x coefficients
    int degrees_of_freedom = 0;
    double unexplained_share = 0;
  };
  // Squared norms of the derivatives by context, of each parameter and part.
  using Squares = std::vector<std::array<Eigen::VectorXd, CandidateScan::kParts>>;
  Eigen::MatrixXd on_basis(int candidate) const;
  Eigen::VectorXd slope_of(int candidate, const Eigen::VectorXd& of_columns) const;
  Solution solve(int candidate, const Eigen::MatrixXd& gram) const;
  CandidateScore score(int candidate, const Solution& solution, const Eigen::VectorXd& slope,
                       double norm) const;
  // Whether so many columns explain nearly all of the residual by chance: they are no evidence.
  bool take_nearly_all(int columns) const {
    constexpr double kMostOfFreedom = 0.75;
    return columns > kMostOfFreedom * fit_.residual_freedom();
  }
  double most_gain(int candidate, const Eigen::VectorXd& slope) const;
  bool can_exceed(double least, int candidate, const Eigen::VectorXd& slope, double norm) const;
  static constexpr double kNoImitation = std::numeric_limits<double>::infinity();
  InPlace in_place(double least, double least_imitation, const Asked& asked,
                   const Place& place) const;
  void project_columns();
  void compute_grams();
  Eigen::MatrixXd gram_of(int candidate, const Squares& squares) const;
  void find_spreads();
  void add_spreads(int candidate, Eigen::MatrixXd& gram) const;
  Eigen::MatrixXd rests(int candidate) const;
  const ValuesAtRows& values_of(int candidate) const { return parts_[scan_.part_[candidate]]; }
  Eigen::VectorXd squares_by_context(int parameter, const ValuesAtRows& values) const;

  template <typename Scalar>
  using RowMajor = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // Sums over the rows of each context of d(row)/d(parameter) . columns(row), of each of some
  // parameters: columns x contexts.
  template <typename Scalar>
  auto sums_by_context(const std::vector<int>& parameters, const ValuesAtRows& values,
                       const RowMajor<Scalar>& columns) const {
    const int size = fit_.row_size();
    const Eigen::MatrixX<Scalar> derivatives =
        fit_.jacobian()(Eigen::all, parameters).template cast<Scalar>();
    std::vector<Eigen::MatrixX<Scalar>> sums(
        parameters.size(), Eigen::MatrixX<Scalar>::Zero(columns.cols(), values.values().rows()));
    for (int row = 0; row < fit_.rows(); ++row)
      for (size_t k = 0; k < sums.size(); ++k) {
        const auto own = derivatives.col(k).segment(row * size, size);
        if ((own.array() == 0).all()) continue;
        sums[k].col(values.context_of_row(row)) +=
            columns.middleRows(row * size, size).transpose().lazyProduct(own);
      }
    return sums;
  }

  // Some columns of one parameter: from the `first` on.
  struct SomeColumns {
    int parameter, first, count;
    const ValuesAtRows& values;
  };
  // Calls take(columns, products) for all columns X, on the machine's threads. With the sums by
  // context of `by_row`, and the values of the columns at the contexts, the products
  // by_row^T X = sums * values.
  template <typename Scalar, typename Take>
  void for_each_product(const RowMajor<Scalar>& by_row, const Take& take) const {
    constexpr int kParametersAtOnce = 4;  // while a row of `by_row` is in the cache
    struct Task {
      std::vector<int> parts, parameters;
    };
    std::vector<Task> tasks;
    const auto add_tasks = [&](const std::vector<int>& parts) {
      for (int parameter = 0, last = 0; parameter < scan_.parameters(); ++parameter) {
        if (std::ranges::none_of(parts, [&](int part) {
              const auto [begin, end] = scan_.columns_of(parameter, part);
              return begin < end;
            }))
          continue;
        if (last++ % kParametersAtOnce == 0) tasks.push_back({parts, {}});
        tasks.back().parameters.push_back(parameter);
      }
    };
    if (parts_[0].has_contexts_of(parts_[1]))
      add_tasks({0, 1});
    else
      for (int part = 0; part < CandidateScan::kParts; ++part) add_tasks({part});
    for_ordered_blocks<int>(
        static_cast<int>(tasks.size()), 1,
        [&](int number, int) {
          const auto& [parts, parameters] = tasks[number];
          const auto sums = sums_by_context(parameters, parts_[parts.front()], by_row);
          for (int part : parts)
            for (size_t p = 0; p < parameters.size(); ++p)
              take_columns(parameters[p], part, sums[p], take);
          return 0;
        },
        [](int) {});
  }

  template <typename Scalar, typename Take>
  void take_columns(int parameter, int part, const Eigen::MatrixX<Scalar>& sums,
                    const Take& take) const {
    constexpr int kColumnsAtOnce = 256;  // bounds the memory of one task
    const ValuesAtRows& of_part = parts_[part];
    const auto [begin, end] = scan_.columns_of(parameter, part);
    const auto found = scan_.periodograms_.find(parameter);
    const bool by_nodes =
        part == CandidateScan::kPosture && found != scan_.periodograms_.end() && !of_part.differ();
    const int middle = by_nodes ? found->second.first : end;
    for (int first = begin; first < middle; first += kColumnsAtOnce) {
      const int count = std::min(kColumnsAtOnce, middle - first);
      Eigen::MatrixX<Scalar> values(sums.cols(), count);
      for (int k = 0; k < count; ++k)
        values.col(k) =
            of_part.values().col(scan_.value_of_column_[first + k]).template cast<Scalar>();
      take(SomeColumns{parameter, first, count, of_part}, Eigen::MatrixX<Scalar>(sums * values));
    }
    if (!by_nodes) return;
    const Eigen::MatrixX<Scalar> of_nodes = found->second.nodes.products(sums);
    int column = middle;
    for (const auto& [sine, near] : found->second.near_of_sine) {
      take(SomeColumns{parameter, column, 2, of_part}, CycleNodes::at(near, of_nodes));
      column += 2;
    }
  }

  // Of best_of_flipped(); see sign_flips.cc.
  struct Draws;
  Eigen::VectorXd leverage_corrected_residual_by_pose() const;
  Draws draw(int flips, std::uint64_t seed) const;
  void draw_block(const Eigen::MatrixXf& signs, int begin, Draws& draws) const;
  Eigen::MatrixXf pulls_by_pose(const SomeColumns& columns, Eigen::Index poses) const;
  Eigen::VectorXd best_of_block(const Draws& draws, int begin, int end) const;

  const CandidateScan& scan_;
  const Linearization& fit_;
  std::array<ValuesAtRows, CandidateScan::kParts> parts_;
  Eigen::MatrixXd on_basis_;                    // Q^T X: rank x columns
  Eigen::VectorXd slopes_;                      // X^T r: columns
  std::vector<Eigen::VectorXd> squared_norms_;  // of the columns X, per candidate
  std::vector<Eigen::MatrixXd> grams_;          // X2^T X2, per candidate
  std::vector<Solution> solutions_;             // of these
};

}  // namespace armtrue
