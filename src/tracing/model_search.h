#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armtrue/tracing/tracing.h"
#include "tracing/linearization.h"
#include "tracing/scan.h"

namespace armtrue {

/// Of the cost, relative, where one fit of a search ends: its figures are compared to two digits.
inline constexpr double kSearchTolerance = 1e-6;

/// The search of trace(): which effects the model has, found forward one by one, and revised. Of
/// the result it fills the fit, its stages, the ranking of the last scan and what chance would have
/// found; the evidence is described afterwards.
class ModelSearch {
 public:
  /// Fits the geometry. Refers to campaign, options and result. Throws std::invalid_argument if no
  /// candidate can be looked for in the measurements.
  ModelSearch(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
              const TraceOptions& options, TraceResult& result);

  /// Adds, exchanges and drops until nothing more lowers EBIC.
  void run();

  /// The model as it stands.
  const CalibrationResult& fit() const { return result_.fit; }

  /// What was found, in the order of the effects of the model.
  const std::vector<Candidate>& chosen() const { return chosen_; }

  /// Where the k-th of the chosen stands among the effects of the model.
  int in_fit(size_t k) const { return declared_ + static_cast<int>(k); }

  /// Puts the chosen, and their effects in the model, in another order.
  void put_in_order(const std::vector<size_t>& order);

  /// All candidates against the fit as it stands.
  struct View {
    Linearization fit;
    ProjectedCandidates projected;

    View(const CandidateScan& scan, const CalibrationResult& result, const Campaign& campaign)
        : fit(result, campaign), projected(scan, fit) {}
  };
  const View& view();
  const CandidateScan& scan() const { return *scan_; }

  /// Of some of the chosen, all on one parameter: what they explain together.
  CandidateScore score_of(const std::vector<int>& chosen);

  /// Of candidates that are not those of the search, all on the same parameter: beside all that is
  /// in the model or, if `effect` is not negative, in the place of that effect of the model.
  std::vector<CandidateScore> scores_of(const std::vector<Candidate>& candidates, int effect);

  /// Family-wise: how often chance makes the best of all candidates look as good.
  double p_value(double score);

  /// With which the k-th of the chosen was added; none where it took another's place.
  std::optional<double> p_at_gate(size_t k) const { return p_at_gate_[k]; }

 private:
  enum class KnownCauses { stay, give_way };  // to what no catalogue names

  bool step();
  void rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order);
  void add(int candidate, double p);
  void begin_with(const Effect& effect);
  void refit(const std::vector<Effect>& start);
  Candidate refine(const Candidate& found, int effect);

  bool revise(KnownCauses known_causes);
  bool revise_one(KnownCauses known_causes);
  std::optional<int> better_than(double score, const std::vector<CandidateScore>& scores,
                                 bool known) const;
  bool merge_into_spline(size_t least);
  void settle_inner_values();
  void drop_idle();
  void remove(const std::vector<int>& indices, std::vector<Effect>& coefficients);
  bool is_new_model();

  double significance() const;
  void describe_null_run(double level);
  bool may_enter(const Candidate& candidate) const;
  bool is_in_model(const Effect& effect) const;
  void note(const std::string& what) const;

  const Campaign& campaign_;
  const TraceOptions& options_;
  TraceResult& result_;
  std::unique_ptr<View> view_;
  std::vector<double> null_scores_;  // of the view, as far as they were asked for
  int declared_ = 0;                 // effects that the robot came with
  int merges_ = 0;
  bool fine_curves_ = false;  // whether they may enter: once nothing simpler is left
  std::optional<CandidateScan> scan_;
  std::vector<Candidate> chosen_;
  std::vector<std::optional<double>> p_at_gate_;
  std::set<std::multiset<std::string>> seen_;
};

}  // namespace armtrue
