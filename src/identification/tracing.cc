#include "armtrue/identification/tracing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "candidates.h"
#include "cross_validation.h"
#include "scan.h"

namespace armtrue {
namespace {

constexpr double kPossibleVariation = 0.02;  // m or rad: a larger one is no effect but a mistake
constexpr double kSameProjection = 0.95;     // correlation from which two candidates are one class
constexpr double kSameEvidence = 6.0;        // EBIC: odds of 20 to 1
constexpr size_t kNearMisses = 300;
constexpr int kTrials = 8;  // candidates that may fail the later gates in one step

class Tracer {
 public:
  Tracer(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
         const TraceOptions& options)
      : campaign_(campaign), options_(options) {
    note("fitting the geometry");
    result_.fit = calibrate(robot, campaign);
    declared_ = static_cast<int>(robot.effects.size());
    result_.stages.push_back(result_.fit);
    candidates_ = catalogue_candidates(catalogue, robot, campaign);
    if (options.beyond_catalogue) {
      const std::vector<Candidate> open = open_candidates(robot, campaign);
      const size_t known = candidates_.size();
      for (const Candidate& candidate : open) candidates_.push_back(candidate);
      // Whoever looks beyond the catalogue has looked at the catalogue too.
      for (size_t k = known; k < candidates_.size(); ++k)
        candidates_[k].log_choices =
            std::log(std::exp(candidates_[k].log_choices) + static_cast<double>(known));
    }
    scan_.emplace(candidates_, robot, campaign);
  }

  TraceResult run() {
    while (static_cast<int>(chosen_.size()) < options_.max_effects && step()) {
      revise();
      // Adding and dropping may not go round in circles: a model seen before ends the search.
      if (!seen_.insert(signature()).second) break;
      result_.stages.push_back(result_.fit);
    }
    describe();
    return std::move(result_);
  }

 private:
  // The chosen effects whatever their order; inner values do not count.
  std::multiset<std::string> signature() const {
    std::multiset<std::string> names;
    for (const Candidate& candidate : chosen_)
      names.insert(candidate.effect.parameter + "|" + to_string(candidate.effect.driver) + "|" +
                   to_string(candidate.effect.shape));
    return names;
  }

  void note(const std::string& what) const {
    if (options_.progress) options_.progress(what);
  }

  static std::vector<int> best_first(const std::vector<CandidateScore>& scores) {
    std::vector<int> order(scores.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return scores[a].score > scores[b].score; });
    return order;
  }

  // Of the right sign, and no larger than such a thing can be.
  bool is_possible(const CandidateScan& scan, const Linearization& fit, int candidate,
                   const CandidateScore& score) const {
    if (scan.candidates()[candidate].only_positive && score.coefficients.maxCoeff() <= 0)
      return false;
    return scan.variation(fit, candidate, score.coefficients) < kPossibleVariation;
  }

  // One forward step; false if nothing more is to be added.
  bool step() {
    note("scanning for effect " + std::to_string(chosen_.size() + 1));
    const Linearization fit(result_.fit, campaign_);
    const std::vector<CandidateScore> scores = scan_->score(fit);
    const std::vector<int> order = best_first(scores);
    rank(scores, order);
    result_.best_score = scores[order.front()].score;
    for (int trial = 0; trial < kTrials && trial < static_cast<int>(order.size()); ++trial) {
      const int candidate = order[trial];
      if (scores[candidate].score <= 0) break;
      if (!is_possible(*scan_, fit, candidate, scores[candidate])) continue;
      const CrossValidation cv =
          CrossValidation::of(fit, scan_->columns(fit, candidate), options_.seed);
      if (cv.gain <= cv.error) continue;
      const double p = family_wise_p(fit, candidate, scores[candidate]);
      if (p >= options_.significance) {
        result_.remaining_p = p;
        return false;
      }
      add(refine(fit, *scan_, candidate), order, p, cv);
      return true;
    }
    result_.remaining_p = family_wise_p(fit, order.front(), scores[order.front()]);
    return false;
  }

  // Signs are flipped on what the candidate leaves (ter Braak 1992): flipping its own effect along would hide a
  // strong effect in the scatter it causes, while on a residual without any effect both ways agree.
  double family_wise_p(const Linearization& fit, int candidate, const CandidateScore& score) const {
    Linearization noise = fit;
    noise.explain(scan_->columns(fit, candidate) * score.coefficients);
    return scan_->family_wise_p(noise, score.score, options_.flips, options_.seed);
  }

  // The same candidate with its inner values (t*, tau) where they explain most.
  Candidate refine(const Linearization& fit, const CandidateScan& among, int candidate) const {
    const Candidate& found = among.candidates()[candidate];
    const std::vector<Candidate> finer = refined_candidates(found, campaign_);
    if (finer.empty()) return found;
    const CandidateScan scan(finer, result_.fit.robot, campaign_);
    const std::vector<CandidateScore> scores = scan.score(fit);
    return scan.candidates()[best_first(scores).front()];
  }

  // The candidates that came nearest when an effect was chosen: if another took its place by
  // mistake, it is among them, and looking there only makes revisions cheap.
  CandidateScan near_misses(const std::vector<int>& order) const {
    std::vector<Candidate> nearest;
    for (size_t k = 0; k < std::min<size_t>(order.size(), kNearMisses); ++k)
      nearest.push_back(scan_->candidates()[order[k]]);
    return {nearest, result_.fit.robot, campaign_};
  }

  void add(const Candidate& candidate, const std::vector<int>& order, double p,
           const CrossValidation& cv) {
    chosen_.push_back(candidate);
    near_misses_.push_back(near_misses(order));
    TracedEffect traced;
    traced.from_catalogue = candidate.from_catalogue;
    traced.evidence.p_value = p;
    traced.evidence.cross_validated_gain = cv.gain;
    traced.evidence.cross_validated_gain_error = cv.error;
    result_.effects.push_back(traced);
    refit({});
  }

  // Refits the geometry and all effects; `start` are coefficients to start from, else zero for new
  // ones.
  void refit(const std::vector<Effect>& start) {
    Robot robot = result_.fit.robot;
    robot.effects.resize(declared_);
    for (size_t k = 0; k < chosen_.size(); ++k) {
      Effect effect = chosen_[k].effect;
      const auto& old = start.empty() ? result_.fit.robot.effects : start;
      const size_t place = static_cast<size_t>(declared_) + k;
      if (place < old.size() && same(old[place], effect))
        effect.coefficients = old[place].coefficients;
      if (effect.coefficients.empty())
        effect.coefficients.resize(
            BoundEffect(effect, robot, campaign_.temperature_names).coefficient_count());
      robot.effects.push_back(effect);
    }
    result_.fit = calibrate(robot, campaign_, result_.fit.set);
  }

  static bool same(const Effect& a, const Effect& b) {
    return a.parameter == b.parameter && a.driver == b.driver && a.shape == b.shape;
  }

  CandidateScan alone(const Candidate& candidate) const {
    return CandidateScan({candidate}, result_.fit.robot, campaign_);
  }

  // Drops effects that the others have made idle, and exchanges those that another now explains
  // better.
  void revise() {
    if (chosen_.size() < 2) return;
    for (int round = 0; round < 4; ++round) {
      const Linearization fit(result_.fit, campaign_);
      bool changed = false;
      for (size_t k = 0; k < chosen_.size() && !changed; ++k) {
        const Linearization reduced = fit.without_effect(declared_ + static_cast<int>(k));
        const double own = alone(chosen_[k]).score(reduced).front().score;
        const CandidateScan& near = near_misses_[k];
        const std::vector<CandidateScore> scores = near.score(reduced);
        int best = -1;
        for (int candidate : best_first(scores)) {
          if (scores[candidate].score <= std::max(own, 0.0) + 2.0) break;
          if (!is_possible(near, reduced, candidate, scores[candidate])) continue;
          best = candidate;
          break;
        }
        std::vector<Effect> coefficients = result_.fit.robot.effects;
        if (best >= 0) {
          const Candidate better = refine(reduced, near, best);
          if (same(better.effect, chosen_[k].effect)) continue;
          chosen_[k] = better;
          result_.effects[k].from_catalogue = better.from_catalogue;
          coefficients[declared_ + k] = {};
        } else if (own <= 0) {
          chosen_.erase(chosen_.begin() + static_cast<std::ptrdiff_t>(k));
          near_misses_.erase(near_misses_.begin() + static_cast<std::ptrdiff_t>(k));
          result_.effects.erase(result_.effects.begin() + static_cast<std::ptrdiff_t>(k));
          coefficients.erase(coefficients.begin() + declared_ + static_cast<std::ptrdiff_t>(k));
        } else {
          continue;
        }
        refit(coefficients);
        changed = true;
      }
      if (!changed) return;
    }
  }

  void rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order) {
    result_.ranking.clear();
    for (int candidate : order) {
      if (result_.ranking.size() == 20) break;
      const CandidateScore& score = scores[candidate];
      if (score.degrees_of_freedom == 0) break;
      RankedCandidate ranked{scan_->candidates()[candidate].effect,
                             score.degrees_of_freedom,
                             score.left,
                             score.gain,
                             score.score,
                             scan_->candidates()[candidate].from_catalogue};
      result_.ranking.push_back(std::move(ranked));
    }
    result_.not_separable.clear();
    for (size_t k = 0; k < scores.size(); ++k)
      if (scores[k].degrees_of_freedom == 0 && scan_->candidates()[k].from_catalogue)
        result_.not_separable.push_back(scan_->candidates()[k].effect);
  }

  // Evidence of each effect beside all the others, and what cannot be told from it.
  void describe() {
    if (chosen_.empty()) return;
    note("looking for what cannot be told apart");
    const Linearization fit(result_.fit, campaign_);
    for (size_t k = 0; k < chosen_.size(); ++k) {
      TracedEffect& traced = result_.effects[k];
      traced.effect = result_.fit.robot.effects[declared_ + k];
      traced.only_prediction = !traced.from_catalogue;
      Linearization reduced = fit.without_effect(declared_ + static_cast<int>(k));
      const CandidateScore own = alone(chosen_[k]).score(reduced).front();
      traced.evidence.delta_ebic = own.score;
      const std::vector<CandidateScore> scores = scan_->score(reduced);
      reduced.set_residual(fit.contribution(declared_ + static_cast<int>(k)));
      const std::vector<CandidateScore> shares = scan_->score(reduced);
      const double whole = std::max(1e-300, reduced.residual_norm());
      std::vector<Rival> rivals;
      for (int candidate : best_first(scores)) {
        const Candidate& other = scan_->candidates()[candidate];
        if (same_place(other.effect, chosen_[k].effect) ||
            scores[candidate].degrees_of_freedom == 0)
          continue;
        const double correlation = std::sqrt(std::clamp(shares[candidate].gain / whole, 0.0, 1.0));
        const double behind = own.score - scores[candidate].score;
        const bool simple =
            scores[candidate].degrees_of_freedom <= std::max(2, own.degrees_of_freedom);
        if (!(simple && correlation >= kSameProjection) && behind > kSameEvidence) continue;
        if (!is_possible(*scan_, reduced, candidate, scores[candidate])) continue;
        if (std::any_of(rivals.begin(), rivals.end(),
                        [&](const Rival& rival) { return same_place(rival.effect, other.effect); }))
          continue;
        rivals.push_back({other.effect, correlation, behind});
      }
      traced.indistinguishable = std::move(rivals);
    }
  }

  // The same cause as far as a name goes: parameter and driver.
  static bool same_place(const Effect& a, const Effect& b) {
    return a.parameter == b.parameter && a.driver == b.driver;
  }

  const Campaign& campaign_;
  const TraceOptions& options_;
  TraceResult result_;
  int declared_ = 0;
  std::vector<Candidate> candidates_;
  std::optional<CandidateScan> scan_;
  std::vector<Candidate> chosen_;
  std::vector<CandidateScan> near_misses_;  // of each chosen effect
  std::set<std::multiset<std::string>> seen_;
};

}  // namespace

TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options) {
  return Tracer(robot, campaign, catalogue, options).run();
}

}  // namespace armtrue
