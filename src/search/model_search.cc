#include "search/model_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "calibration/refit.h"
#include "search/candidates.h"
#include "search/cross_validation.h"

namespace armtrue {
namespace {

constexpr double kMinFallToExchange = 2.0;  // EBIC, before an effect gives way to another
// From this many on, effects of one parameter and driver are taken for the pieces of one curve; two
// may be the two that there are.
constexpr size_t kMinPiecesOfCurve = 3;
// Exchanges, and inner values beside each other, settle in one or two rounds; after these bounds
// they are taken to go round in circles.
constexpr int kMaxRevisions = 4, kMaxSettlings = 2;
constexpr size_t kMaxModels = 100;  // several times what the longest search went through
constexpr int kMaxMerges = 50;      // likewise
constexpr int kMaxTrials = 8;       // candidates of one step that may fail the later gates
constexpr size_t kMaxRanked = 20;

RankedCandidate ranked(const Candidate& candidate, const CandidateScore& score) {
  return {candidate.effect, candidate.separated_by, score.degrees_of_freedom,
          score.unexplained_share, score.score};
}

class ModelSearch {
 public:
  ModelSearch(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
              const TraceOptions& options)
      : options_(options),
        campaign_(campaign),
        result_{EffectModel(robot, campaign, catalogue, options), {}, {}, {}, 0, 1, {}},
        model_(result_.model) {
    result_.stages.push_back(model_.fit());
  }
  ModelSearch(const ModelSearch&) = delete;  // model_ refers to result_
  ModelSearch& operator=(const ModelSearch&) = delete;

  void run();
  SearchResult take() { return std::move(result_); }

 private:
  enum class KnownCauses { stay, give_way };  // to what no catalogue names

  bool step();
  void rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order);
  void begin_with(const Effect& effect);
  double p_of(double score);

  bool revise(KnownCauses known_causes);
  bool revise_one(KnownCauses known_causes);
  std::optional<int> better_than(double least, const std::vector<CandidateScore>& scores,
                                 bool known) const;
  bool merge_into_spline(size_t least);
  bool merge_into_distortion();
  bool is_piece_of_distortion(const Candidate& candidate) const;
  void settle_inner_values();
  void drop_idle();
  void split_families();
  void hold_family_of_most_arms();
  Eigen::VectorXd errors_left_out() const;
  bool is_new_model();
  bool may_enter(const Candidate& candidate) const;
  const std::vector<Candidate>& candidates() const { return model_.scan().candidates(); }

  const TraceOptions& options_;
  const Campaign& campaign_;
  SearchResult result_;
  EffectModel& model_;
  int merges_ = 0;
  bool details_ = false;  // whether they may enter: once nothing simpler is left
  bool failed_at_gate_ = false;  // whether the last step did, and p of its best is known
  std::set<std::multiset<std::string>> seen_;
};

void ModelSearch::run() {
  for (const Effect& effect : options_.start) begin_with(effect);
  if (!model_.chosen().empty()) {
    revise(KnownCauses::give_way);
    result_.stages.push_back(model_.fit());
  }
  // While effects are missing, a curve also explains part of them. So a known cause gives way to a
  // curve only when nothing is left to add.
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
        if (!failed_at_gate_) result_.remaining_p = p_of(result_.best_score);
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
  split_families();
  hold_family_of_most_arms();
  model_.complete();
  result_.stages.back() = model_.fit();
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
  for (int candidate : order) {
    if (scores[candidate].score <= 0 || trials == kMaxTrials) break;
    if (!may_enter(candidates()[candidate])) continue;
    ++trials;
    if (!model_.scan().is_possible(candidate, scores[candidate].coefficients)) continue;
    const CrossValidation cv =
        CrossValidation::of(fit, projected.directions(candidate), options_.seed);
    if (cv.gain <= cv.error) continue;
    const double p = p_of(scores[candidate].score);
    if (p >= model_.significance() ||
        static_cast<int>(model_.chosen().size()) == options_.max_effects) {
      result_.remaining_p = p;
      failed_at_gate_ = true;
      return false;
    }
    model_.add(model_.refined(candidates()[candidate], -1), p);
    return true;
  }
  return false;
}

double ModelSearch::p_of(double score) {
  const EffectModel::Chance chance = model_.chance_of(score);
  result_.null_run = chance.run;
  return chance.p;
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

// Adds an effect that was asked for without asking the gates, unless nothing of it shows.
void ModelSearch::begin_with(const Effect& effect) {
  const auto found =
      std::find_if(candidates().begin(), candidates().end(),
                   [&](const Candidate& candidate) { return same_form(candidate.effect, effect); });
  if (found == candidates().end())
    throw std::invalid_argument(effect.parameter + " by " + to_string(effect.driver) +
                                " is no candidate of the search that is to begin with it");
  const CandidateScore score = model_.view().projected.scores()[found - candidates().begin()];
  if (score.degrees_of_freedom == 0) return;
  const double p = p_of(score.score);
  model_.add(model_.refined(*found, -1), p);
}

// Exchanges effects that another candidate now explains better, and drops effects that the others
// have made idle. False if nothing changed.
bool ModelSearch::revise(KnownCauses known_causes) {
  int round = 0;
  while (round < kMaxRevisions && !model_.chosen().empty() && revise_one(known_causes)) ++round;
  return round > 0;
}

// Makes the one change that lowers EBIC most, so that the order of the additions does not matter.
bool ModelSearch::revise_one(KnownCauses known_causes) {
  const ProjectedCandidates& projected = model_.view().projected;
  const std::vector<Candidate>& chosen = model_.chosen();
  int effect = -1;
  std::optional<Candidate> other;
  double most = 0;
  for (size_t k = 0; k < chosen.size(); ++k) {
    const double own = model_.score_of({static_cast<int>(k)}).score;
    const double least = std::max(own, 0.0) + kMinFallToExchange;
    const std::vector<CandidateScore> scores =
        projected.scores_above(least, {model_.in_fit(k)});
    const bool by_known = chosen[k].from_catalogue && known_causes == KnownCauses::stay;
    const auto better = better_than(least, scores, by_known);
    const double fall = better ? scores[*better].score - own : -own;
    if (fall < most || (!better && own > 0)) continue;
    std::optional<Candidate> refined;
    if (better) refined = model_.refined(candidates()[*better], model_.in_fit(k));
    if (refined && same_form(refined->effect, chosen[k].effect)) continue;
    most = fall;
    effect = static_cast<int>(k);
    other = refined;
  }
  if (effect < 0) return false;
  if (other)
    model_.exchange(static_cast<size_t>(effect), *other);
  else
    model_.drop({effect});
  return true;
}

// The best candidate (`known`: of the catalogue) of possible size that scores more than `least`.
std::optional<int> ModelSearch::better_than(double least, const std::vector<CandidateScore>& scores,
                                            bool known) const {
  for (int candidate : best_first(scores)) {
    if (scores[candidate].score <= least) break;
    const Candidate& other = candidates()[candidate];
    if ((other.from_catalogue || !known) && may_enter(other) &&
        model_.scan().is_possible(candidate, scores[candidate].coefficients))
      return candidate;
  }
  return std::nullopt;
}

// Replaces `least` or more effects of one parameter and driver by one fine curve where EBIC prefers
// it. False if nothing changed.
bool ModelSearch::merge_into_spline(size_t least) {
  const std::vector<Candidate>& chosen = model_.chosen();
  std::vector<int> merged;
  int curve = -1;
  double most = kMinFallToExchange;
  for (size_t first = 0; first < chosen.size(); ++first) {
    std::vector<int> together, effects;
    for (size_t k = first; k < chosen.size(); ++k)
      if (same_place(chosen[k].effect, chosen[first].effect)) {
        together.push_back(static_cast<int>(k));
        effects.push_back(model_.in_fit(k));
      }
    const bool seen = std::any_of(chosen.begin(), chosen.begin() + first, [&](const auto& c) {
      return same_place(c.effect, chosen[first].effect);
    });
    if (together.size() < least || seen) continue;
    const double own = model_.score_of(together).score;
    const std::vector<CandidateScore> scores =
        model_.view().projected.scores_above(own + most, effects);
    for (size_t c = 0; c < scores.size(); ++c) {
      const Candidate& candidate = candidates()[c];
      if (!candidate.fine || !same_place(candidate.effect, chosen[first].effect) ||
          scores[c].score <= own + most)
        continue;
      most = scores[c].score - own;
      merged = together;
      curve = static_cast<int>(c);
    }
  }
  if (curve < 0 || ++merges_ > kMaxMerges) return false;
  model_.merge(merged, candidates()[curve]);
  return true;
}

// Whether it may be a part of how the instrument distorts space: an error of its line of sight that
// stays in time, or what no rigid arm does.
bool ModelSearch::is_piece_of_distortion(const Candidate& candidate) const {
  const Effect& effect = candidate.effect;
  if (!effect.parameter.starts_with("instrument."))
    return !candidate.from_catalogue && is_of_no_arm(effect, model_.fit().robot.chain);
  return effect.driver.kind != DriverKind::time && effect.driver.kind != DriverKind::incidence;
}

// Replaces two or more pieces of a distortion of space by one where EBIC prefers it. False if
// nothing changed.
bool ModelSearch::merge_into_distortion() {
  std::vector<int> pieces, effects;
  for (size_t k = 0; k < model_.chosen().size(); ++k)
    if (is_piece_of_distortion(model_.chosen()[k])) {
      pieces.push_back(static_cast<int>(k));
      effects.push_back(model_.in_fit(k));
    }
  if (pieces.size() < 2) return false;
  double most = model_.score_of(pieces).score + kMinFallToExchange;
  const std::vector<CandidateScore> scores = model_.view().projected.scores_without(effects);
  std::optional<Candidate> distortion;
  for (size_t c = 0; c < scores.size(); ++c)
    if (is_polynomial(candidates()[c].effect.shape) && scores[c].score > most) {
      most = scores[c].score;
      distortion = candidates()[c];
    }
  if (!distortion || ++merges_ > kMaxMerges) return false;
  model_.merge(pieces, *distortion);
  return true;
}

// Chooses inner values (t*, tau, frequency) beside all effects; each was chosen beside those that
// were in the model before it.
void ModelSearch::settle_inner_values() {
  for (int round = 0; round < kMaxSettlings; ++round) {
    const std::vector<Candidate>& chosen = model_.chosen();
    std::vector<Candidate> settled;
    for (size_t k = 0; k < chosen.size(); ++k)
      settled.push_back(model_.refined(chosen[k], model_.in_fit(k)));
    if (std::equal(
            settled.begin(), settled.end(), chosen.begin(),
            [](const Candidate& a, const Candidate& b) { return same_form(a.effect, b.effect); }))
      return;
    model_.settle(settled);
    result_.stages.back() = model_.fit();
  }
}

// Drops effects that stood for what the inner values of others missed, and those that have become
// impossible beside the others.
void ModelSearch::drop_idle() {
  for (;;) {
    int idle = -1;
    double least = 0;
    for (int k = 0; k < static_cast<int>(model_.chosen().size()); ++k) {
      const double score = model_.score_of({k}).score;
      const bool impossible = !model_.has_possible_sign(static_cast<size_t>(k));
      if (score > least && !impossible) continue;
      least = std::min(least, score);
      idle = k;
      if (impossible) break;
    }
    if (idle < 0) return;
    model_.drop({idle});
    result_.stages.back() = model_.fit();
  }
}

// Members of a family that the readings speak for become findings. The others stay in the model,
// held by the prior that they share, if the readings speak for all of them together.
void ModelSearch::split_families() {
  bool found = false;
  while (model_.split_family()) found = true;
  if (!found) return;
  constexpr double kAic = 2;  // of the gain per coefficient, from which it predicts better with it
  for (;;) {
    std::vector<int> weak;
    for (int k = 0; k < static_cast<int>(model_.chosen().size()); ++k)
      if (model_.chosen()[static_cast<size_t>(k)].effect.family && model_.score_of({k}).score <= 0)
        weak.push_back(k);
    if (weak.empty()) break;
    const CandidateScore together = model_.score_of(weak);
    if (together.gain > kAic * together.degrees_of_freedom)
      for (auto k = weak.rbegin(); k != weak.rend(); ++k) model_.hold(static_cast<size_t>(*k));
    else
      model_.drop(weak);
  }
  for (CalibrationResult& stage : result_.stages) {
    std::vector<Effect> singles;
    for (const Effect& effect : stage.robot.effects)
      for (Effect& single : single_effects(effect)) singles.push_back(std::move(single));
    stage.robot.effects = std::move(singles);
  }
  result_.stages.back() = model_.fit();
}

// What most arms have needs no evidence of its own to stay in the model, only none against it:
// members of such a family stay, held by the prior that they share, unless poses left out are
// predicted worse with them.
void ModelSearch::hold_family_of_most_arms() {
  const auto found = std::ranges::find_if(candidates(), [](const Candidate& candidate) {
    return candidate.of_most_arms && !candidate.effect.members.empty();
  });
  if (found == candidates().end()) return;
  Candidate family = *found;
  std::erase_if(family.effect.members,
                [&](const Effect& member) { return model_.contains(member); });
  if (family.effect.members.empty()) return;
  const Eigen::VectorXd without = errors_left_out();
  model_.add(family, 1);
  if (errors_left_out().mean() > without.mean()) {
    model_.drop({static_cast<int>(model_.chosen().size()) - 1});
    return;
  }
  const auto singles = static_cast<int>(model_.chosen().back().effect.members.size());
  model_.split_family();
  for (int k = 0; k < singles; ++k) model_.hold(model_.chosen().size() - 1);
  result_.stages.back() = model_.fit();
}

// Mean error of the position of each pose by a fit of the same model that has not seen it [m].
Eigen::VectorXd ModelSearch::errors_left_out() const {
  constexpr int kFolds = 10;
  const CalibrationResult& fit = model_.fit();
  const std::vector<int> pose = campaign_.pose_by_id();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(std::ssize(campaign_.pose_ids)), weights = sums;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<int> inside, outside;
    for (int row = 0; row < campaign_.rows(); ++row)
      (pose[row] % kFolds == fold ? outside : inside).push_back(row);
    const CalibrationResult part =
        refit(fit.robot, campaign_.select(inside), fit, kSearchTolerance);
    const Evaluation evaluation = evaluate(part.robot, campaign_.select(outside));
    for (size_t k = 0; k < outside.size(); ++k) {
      const double weight = fit.weights[outside[k]];
      sums[pose[outside[k]]] += weight * evaluation.position[k];
      weights[pose[outside[k]]] += weight;
    }
  }
  return sums.cwiseQuotient(weights.cwiseMax(1e-300));
}

// False once a model comes back, or after kMaxModels (frequencies seldom come back to the last
// digit): then exchanges stop, so that adding and dropping cannot go round in circles. Neither the
// order of the effects nor their inner values count.
bool ModelSearch::is_new_model() {
  std::multiset<std::string> names;
  for (const Candidate& candidate : model_.chosen())
    names.insert(candidate.effect.parameter + "|" + to_string(candidate.effect.driver) + "|" +
                 to_string(candidate.effect.shape));
  return seen_.insert(names).second && seen_.size() < kMaxModels;
}

bool ModelSearch::may_enter(const Candidate& candidate) const {
  return (details_ || !candidate.detail) && !model_.contains(candidate.effect);
}

}  // namespace

SearchResult search_effects(const Robot& robot, const Campaign& campaign,
                            const Catalogue& catalogue, const TraceOptions& options) {
  ModelSearch search(robot, campaign, catalogue, options);
  search.run();
  return search.take();
}

}  // namespace armtrue
