#include "search/model_search.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "search/cross_validation.h"
#include "search/search_phases.h"

namespace armtrue {
namespace {

// This many effects of one parameter and driver are taken as parts of one curve; two may be two
// real effects.
constexpr size_t kMinPiecesOfCurve = 3;
constexpr size_t kMaxModels = 100;  // several times what the longest search went through
constexpr int kMaxTrials = 8;       // candidates of one step that may fail the later gates
constexpr size_t kMaxRanked = 20;

RankedCandidate ranked(const Candidate& candidate, const CandidateScore& score) {
  return {candidate.effect, candidate.separated_by, score.degrees_of_freedom,
          score.unexplained_share, score.score};
}

}  // namespace

void ModelSearch::run() {
  for (const Effect& effect : options_.start) begin_with(effect);
  if (!model_.chosen().empty()) {
    revise(KnownCauses::give_way);
    result_.stages.push_back(model_.fit());
  }
  // While effects are missing, a curve also explains part of them. So a curve replaces a known
  // cause only when nothing is left to add.
  bool may_revise = true;
  for (;;) {
    while (step()) {
      if (may_revise && model_.chosen().size() > 1) revise(KnownCauses::stay);
      merge_into_spline(kMinPiecesOfCurve);
      merge_into_distortion();
      may_revise &= is_new_model();
      result_.stages.push_back(model_.fit());
    }
    if (!(may_revise && revise(KnownCauses::give_way)) && !merge_into_spline(2)) {
      if (details_) {
        if (!failed_at_gate_) result_.remaining_p = model_.chance_of(result_.best_score);
        result_.null_run = model_.null_run();
        break;
      }
      details_ = true;
      continue;
    }
    may_revise &= is_new_model();
    result_.stages.back() = model_.fit();
  }
  settle_inner_values();
  drop_idle();
  drop_by_refit();
  prefer_distortion();
  split_families();
  hold_family_of_most_arms();
  if (std::optional<CalibrationResult> geometry = model_.settle_tool())
    result_.stages.front() = *std::move(geometry);
  end_last_stage();
}

// The geometry alone stays the first stage, also where the end of the search only holds effects by
// their prior.
void ModelSearch::end_last_stage() {
  std::vector<CalibrationResult>& stages = result_.stages;
  const bool holds_more = model_.fit().robot.effects.size() > stages.front().robot.effects.size();
  if (stages.size() == 1 && holds_more)
    stages.push_back(model_.fit());
  else
    stages.back() = model_.fit();
}

// One forward step; false if nothing more is to be added.
bool ModelSearch::step() {
  if (options_.progress)
    options_.progress("scanning for effect " + std::to_string(model_.chosen().size() + 1));
  const auto& [fit, projected] = model_.view();
  const std::vector<CandidateScore> scores = projected.scores();
  const std::vector<int> order = best_first(scores);
  rank(scores, order);
  result_.best_score = scores[order.front()].score;
  failed_at_gate_ = false;
  int trials = 0;
  std::optional<CrossValidation> left_out;
  for (int candidate : order) {
    if (scores[candidate].score <= 0 || trials == kMaxTrials) break;
    if (!may_enter(candidates()[candidate])) continue;
    ++trials;
    if (!model_.scan().is_possible(candidate, scores[candidate].coefficients)) continue;
    if (!left_out) left_out.emplace(fit, options_.seed);
    const GainLeftOut cv = left_out->of(projected.directions(candidate));
    if (cv.gain <= cv.error) continue;
    const double p = model_.chance_of(scores[candidate].score);
    if (p >= model_.significance() ||
        static_cast<int>(model_.chosen().size()) == options_.max_effects) {
      result_.remaining_p = p;
      failed_at_gate_ = true;
      return false;
    }
    model_.add(model_.refined(candidates()[candidate], -1), p);
    settle_place_of(model_.chosen().size() - 1);
    return true;
  }
  return false;
}

void ModelSearch::rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order) {
  result_.ranking.clear();
  for (int candidate : order) {
    if (result_.ranking.size() == kMaxRanked) break;
    const CandidateScore& score = scores[candidate];
    if (!candidates()[candidate].effect.members.empty()) continue;  // its members are ranked
    if (score.degrees_of_freedom == 0) break;
    result_.ranking.push_back(ranked(candidates()[candidate], score));
  }
  result_.not_separable.clear();
  for (size_t k = 0; k < scores.size(); ++k)
    if (scores[k].degrees_of_freedom == 0 && candidates()[k].from_catalogue &&
        candidates()[k].effect.members.empty() && !model_.contains(candidates()[k].effect) &&
        std::ranges::none_of(result_.not_separable, [&](const RankedCandidate& listed) {
          return same_place(listed.effect, candidates()[k].effect) &&
                 listed.effect.shape.kind == candidates()[k].effect.shape.kind;
        }))
      result_.not_separable.push_back(ranked(candidates()[k], scores[k]));
}

// Adds an effect of the options without the criteria, unless the model imitates it completely.
void ModelSearch::begin_with(const Effect& effect) {
  const auto found =
      std::find_if(candidates().begin(), candidates().end(),
                   [&](const Candidate& candidate) { return same_form(candidate.effect, effect); });
  if (found == candidates().end())
    throw std::invalid_argument(to_string(effect.parameter) + " by " + to_string(effect.driver) +
                                " is no candidate of the search that is to begin with it");
  const CandidateScore score = model_.view().projected.scores()[found - candidates().begin()];
  if (score.degrees_of_freedom == 0) return;
  const double p = model_.chance_of(score.score);
  model_.add(model_.refined(*found, -1), p);
}

// False once a model comes back, or after kMaxModels (frequencies seldom come back to the last
// digit): then exchanges stop, so that adding and dropping cannot repeat for ever. The comparison
// ignores the order of the effects and their inner values.
bool ModelSearch::is_new_model() {
  std::multiset<std::string> names;
  for (const Candidate& candidate : model_.chosen())
    names.insert(to_string(candidate.effect.parameter) + "|" + to_string(candidate.effect.driver) + "|" +
                 to_string(candidate.effect.shape));
  return seen_.insert(names).second && seen_.size() < kMaxModels;
}

bool ModelSearch::may_enter(const Candidate& candidate) const {
  return (details_ || !candidate.detail) && !model_.contains(candidate.effect);
}

SearchResult search_effects(const Robot& robot, const Campaign& campaign,
                            const Catalogue& catalogue, const TraceOptions& options) {
  ModelSearch search(robot, campaign, catalogue, options);
  search.run();
  return search.take();
}

}  // namespace armtrue
