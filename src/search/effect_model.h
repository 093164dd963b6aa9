#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/search/search.h"
#include "search/projection.h"

namespace armtrue {

/// Relative fall of the cost at which a fit of the search ends. Its figures are compared to two
/// digits.
inline constexpr double kSearchTolerance = 1e-6;

/// The model of a search: geometry and the effects chosen so far, fitted together. Each change
/// refits everything. It also scores all candidates of the search, beside its effects or in place
/// of one.
class EffectModel {
 public:
  /// Fits the geometry. Keeps references to `campaign` and `options`, which must outlive it. Throws
  /// std::invalid_argument if the measurements allow no candidate.
  EffectModel(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
              const TraceOptions& options);

  const CalibrationResult& fit() const { return fit_; }
  /// The chosen candidates, in the order of the effects of the model.
  const std::vector<Candidate>& chosen() const { return chosen_; }
  int chosen_count() const { return static_cast<int>(chosen_.size()); }
  /// Number of effects before the chosen ones: those that were declared and those that are held.
  int declared() const { return declared_; }
  /// Index of the k-th chosen candidate among the effects of the model.
  int in_fit(int k) const { return declared_ + k; }
  /// The p with which the k-th chosen candidate was added; none if it replaced another one.
  std::optional<double> p_at_gate(int k) const { return p_at_gate_[k]; }
  /// Whether the k-th chosen candidate has coefficients that its law allows.
  bool is_allowed(int k) const;
  /// Whether the model has this effect, declared or chosen.
  bool contains(const Effect& effect) const;
  /// The distortion of space with most coefficients among the candidates.
  std::optional<Candidate> finest_distortion() const;

  /// How many members of the k-th chosen candidate, a family, these readings show: those whose
  /// largest coefficient alone would lower BIC.
  int members_shown(int k);

  void add(const Candidate& candidate, double p);
  void exchange(int k, const Candidate& candidate);
  void drop(const std::vector<int>& ascending);
  /// Replaces chosen families by their members, each as a chosen candidate of its own; they still
  /// share their prior deviation. False if there is none.
  bool split_families();
  /// Keeps chosen candidates in the model, but not among the chosen ones: only their prior holds
  /// them.
  void hold(const std::vector<int>& ascending);
  /// Replaces some chosen candidates by one.
  void merge(const std::vector<int>& ascending, const Candidate& candidate);
  /// Replaces all chosen candidates by the same with other inner values.
  void settle(const std::vector<Candidate>& candidates);
  /// Refits by least squares, or again by the law of the readings: to this law the smaller part of
  /// the readings looks like blunders as long as the model lacks what makes them differ.
  void fit_by_least_squares(bool by_least_squares);
  /// Ends a search: coordinates of the tool that only small angles of the arm show keep the value
  /// of the file, unless BIC is against it. Returns the geometry without effects for this tool, if
  /// the search began with another one.
  std::optional<CalibrationResult> settle_tool();
  /// Completes the fit with what refits during a search omit (see refit.h).
  void complete();
  /// The same with the chosen candidates in another order.
  void complete_in_order(const std::vector<int>& order);

  /// The fit as a linear problem. Valid until the next change, as view() is.
  const Linearization& linear();
  /// And all candidates projected off it, which takes most of the time of a search.
  struct View {
    const Linearization& fit;
    const ProjectedCandidates& projected;
  };
  View view();
  const CandidateScan& scan() const { return *scan_; }

  /// A model as it was fitted, to come back to.
  struct Fitted {
    std::vector<Candidate> chosen;
    CalibrationResult fit, near;
    Robot start;
    std::shared_ptr<const Linearization> linear;
    std::shared_ptr<const ProjectedCandidates> projected;

    /// Without what can be made again.
    void forget_view();
  };
  Fitted fitted() const { return {chosen_, fit_, near_, start_, linear_, projected_}; }
  /// Restores an earlier model with the same number of effects, before exchanges. It stays noted
  /// which effects replaced another one.
  void come_back(const Fitted& before);

  /// What some chosen candidates, all on one parameter, explain together.
  CandidateScore score_of(const std::vector<int>& chosen);
  /// The same with the known loss of the model without them.
  CandidateScore score_of(const std::vector<int>& chosen, const Linearization::Loss& loss);
  /// What chosen members of one family, and others that its prior holds (numbers in the fit),
  /// explain together: one cause, with the charge of the whole family.
  CandidateScore score_of_members(const std::vector<int>& chosen, const std::vector<int>& held);
  /// Numbers in the fit of the effects that the prior of the family of the k-th chosen candidate
  /// holds.
  std::vector<int> held_with(int k) const;
  /// What the k-th chosen candidate explains by a refit without it, under the same law of the
  /// readings.
  CandidateScore refitted_score_of(int k);
  /// Scores of candidates outside the scan, all on one parameter: beside the model or, if `effect`
  /// is not negative, in the place of that effect.
  std::vector<CandidateScore> scores_of(const std::vector<Candidate>& candidates, int effect);
  /// Candidates outside the scan in the place of an effect of the model.
  ProjectedCandidates::InPlace in_place_of(const std::vector<Candidate>& candidates, int effect);
  struct Refined {
    Candidate candidate;
    double score;
    int number;  ///< of the candidate among those that were tried
  };
  /// The candidate with the best inner values (t*, tau, frequency) and its score; none if its shape
  /// has no inner value. `effect` as for scores_of().
  std::optional<Refined> with_best_inner_values(const Candidate& found, int effect);
  /// The same candidate, or itself if its shape has no inner value.
  Candidate refined(const Candidate& found, int effect);

  /// Level below which a family-wise p allows an addition.
  double significance();
  /// The share of the draws of the null run whose best candidate scores as high: family-wise p.
  double chance_of(double score);
  /// The null run of the present model.
  NullRun null_run();

 private:
  Refined best_of(const std::vector<Candidate>& candidates, int effect);
  Refined with_best_frequency(const Candidate& found, int effect);
  void drop_impossible_members(int k);
  std::vector<double> t_of_members(int k) const;
  Candidate alone(const Effect& single) const;
  bool is_allowed(const Candidate& candidate, const std::vector<Coefficient>& fitted) const;
  double standard_deviation(int effect, Eigen::Index coefficient) const;
  void refit(const std::vector<Effect>& start);
  void start_from(const std::vector<Effect>& start);
  void forget_view();
  void remove(const std::vector<int>& ascending, std::vector<Effect>& coefficients);
  void draw_null_scores(int flips);

  const Campaign& campaign_;
  const TraceOptions& options_;
  KinematicChain file_;         // as the robot came
  CalibrationResult as_filed_;  // the geometry, the tool as in the file where it is not shown
  CalibrationResult fit_;
  CalibrationResult near_;  // the fit before, from which this one started,
  Robot start_;             // and its robot
  int declared_ = 0;        // effects that the robot came with
  bool by_least_squares_ = false;
  std::unique_ptr<const CandidateScan> scan_;
  std::vector<Candidate> chosen_;
  std::vector<std::optional<double>> p_at_gate_;
  // Of the present fit, once asked for.
  std::shared_ptr<const Linearization> linear_;
  std::shared_ptr<const ProjectedCandidates> projected_;
  std::vector<double> null_scores_;  // as many as were asked for
  std::optional<double> significance_;
};

}  // namespace armtrue
