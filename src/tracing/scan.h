#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "armtrue/effects/robot_model.h"
#include "tracing/linearization.h"

namespace armtrue {

/// One effect that may be missing, with the price of having looked at it among others.
struct Candidate {
  Effect effect;           ///< without coefficients
  double log_choices = 0;  ///< ln of how many candidates were tried up to and including its kind
  bool only_positive = false;
  bool from_catalogue = false;
  std::string separated_by{};  ///< in words, from the catalogue
  /// One cycle over the travel covered [cycles per turn]: a frequency from a periodogram and one
  /// nearer than this are the same. 0: the frequency is fixed.
  double frequency_resolution = 0;
  /// A curve of many coefficients, which could stand for almost anything that the driver does: for
  /// where simpler effects do not suffice.
  bool fine = false;
};

/// What a candidate would explain.
struct CandidateScore {
  int degrees_of_freedom = 0;  ///< independent columns left after projection; 0: not separable
  double left = 0;             ///< share of its largest column that no known parameter can imitate
  double gain = 0;             ///< fall of the sum of squares of the whitened residuals
  double score = 0;            ///< fall of EBIC; positive is better than not having it
  Eigen::VectorXd coefficients;
};

/// The candidates in the order of their scores, best first; those whose scores differ by no more
/// than rounding stay in their order.
std::vector<int> best_first(const std::vector<CandidateScore>& scores);

/// Many candidates and what their drivers and shapes read in every row of a campaign, computed
/// once: candidates that differ in the parameter alone share it.
class CandidateScan {
 public:
  CandidateScan(const std::vector<Candidate>& candidates, const Robot& robot,
                const Campaign& campaign);

  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Whitened columns of one candidate, before projection.
  Eigen::MatrixXd columns(const Linearization& fit, int candidate) const;

  /// Largest standard deviation over the campaign of what the candidate adds to a parameter
  /// [m, rad]; of the instrument's scale, which is no unknown itself, the RMS.
  double variation(int candidate, const Eigen::VectorXd& coefficients) const;

  /// Whether a candidate may have these coefficients: of the right sign, and no larger than such a
  /// thing can be. Several coefficients are the first moments of masses that nobody stated, of
  /// either sign.
  bool is_possible(int candidate, const Eigen::VectorXd& coefficients) const;

 private:
  friend class ProjectedCandidates;

  // A column is the derivative with respect to one parameter times one value of a driver's shape;
  // the columns of one parameter stand together.
  struct Term {
    int coefficient, parameter, column;
  };

  std::vector<Candidate> candidates_;
  std::vector<std::vector<Term>> terms_;
  std::vector<int> coefficient_count_;
  std::vector<int> moment_of_row_;  // rows whose context is the same share a moment
  Eigen::MatrixXf values_;          // moments x values; a candidate needs no more digits
  std::vector<int> value_of_column_, first_column_;  // per column; per parameter and one past
};

/// All candidates as one fit leaves them: projected off everything that is in the model, never the
/// raw columns on the residual of a frozen model, which would shrink the estimate.
class ProjectedCandidates {
 public:
  /// Refers to both arguments.
  ProjectedCandidates(const CandidateScan& scan, const Linearization& fit);

  /// Each candidate beside all that is in the model.
  std::vector<CandidateScore> scores() const;

  /// What a candidate would add to the basis of the fit, as orthonormal columns.
  Eigen::MatrixXd directions(int candidate) const;

  /// Each candidate in the place of some effects of the model.
  std::vector<CandidateScore> scores_without(const std::vector<int>& effects) const;

  /// How each candidate can imitate one effect of the model: the coefficients with which it comes
  /// closest to what that effect explains, both projected off the rest; the gain is the squared
  /// cosine of the angle between them.
  std::vector<CandidateScore> imitations(int effect) const;

  /// Effects of the model, all on one parameter, together beside the others; `log_choices` is the
  /// sum of what looking for each has cost.
  CandidateScore score_of(const std::vector<int>& effects, const std::string& parameter,
                          double log_choices) const;

  /// The null run: the score of the best of all candidates on the residual with signs flipped pose
  /// by pose, once for each draw.
  std::vector<double> best_of_flipped(int flips, std::uint64_t seed) const;

 private:
  // What makes the columns that are left of a candidate orthonormal, dependent ones left out:
  // with the inverse of their Gram matrix, whitening^T whitening = inverse.
  struct Solution {
    Eigen::MatrixXd whitening;  // degrees of freedom x coefficients
    int degrees_of_freedom = 0;
    double left = 0;
  };
  Eigen::MatrixXd on_basis(int candidate) const;
  Solution solve(int candidate, const Eigen::MatrixXd& projected,
                 const Eigen::MatrixXd& returned) const;
  std::vector<CandidateScore> scores(const Linearization::Loss& loss, bool with_residual) const;
  double ebic_fall(const std::string& parameter, double log_choices, int degrees_of_freedom,
                   double gain, double residual_norm) const;
  Eigen::VectorXd leverage_corrected_residual_by_pose() const;
  template <typename Columns>
  Eigen::MatrixXd moment_sums(int parameter, const Columns& columns) const;

  const CandidateScan& scan_;
  const Linearization& fit_;
  Eigen::MatrixXd on_basis_;            // rank x columns
  Eigen::VectorXd slopes_;              // columns
  std::vector<Eigen::MatrixXd> grams_;  // of the raw columns, per candidate
};

}  // namespace armtrue
