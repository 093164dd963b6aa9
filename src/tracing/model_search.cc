#include "tracing/model_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "calibration/registration.h"
#include "campaign/sessions.h"
#include "tracing/candidates.h"
#include "tracing/cross_validation.h"

namespace armtrue {
namespace {

constexpr double kClearlyBetter = 2.0;  // EBIC, before an effect gives way to another
// Effects of one parameter and driver that look like the pieces of one curve; two may be the two
// that there are.
constexpr size_t kManyOfOnePlace = 3;
// Rounds after which exchanges, and inner values beside each other, go round in circles rather than
// on: each settles in one or two.
constexpr int kRevisions = 4, kSettlings = 2;
constexpr size_t kMaxModels = 100;  // some times what the longest search has gone through
constexpr int kMaxMerges = 50;      // likewise
constexpr int kTrials = 8;          // candidates that may fail the later gates in one step

// The fewer were tried the better, then by what it is, the joint itself first: bending that turns
// about a joint's axis is its compliance. The order in files does not matter.
bool comes_before(const Candidate& a, const Candidate& b) {
  const auto key = [](const Candidate& candidate) {
    const Effect& effect = candidate.effect;
    const bool is_joint = effect.parameter.ends_with(".theta");
    const Driver& driver = effect.driver;
    const Shape& shape = effect.shape;
    return std::tuple(candidate.log_choices, !is_joint, effect.parameter, driver.kind, driver.joint,
                      driver.second_joint, driver.where, driver.factor, shape.kind, shape.harmonic,
                      shape.basis, shape.count, shape.at, shape.tau, shape.low, shape.high);
  };
  return key(a) < key(b);
}

RankedCandidate ranked(const Candidate& candidate, const CandidateScore& score) {
  return {candidate.effect, candidate.separated_by, score.degrees_of_freedom, score.left,
          score.score};
}

}  // namespace

ModelSearch::ModelSearch(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                         const TraceOptions& options, TraceResult& result)
    : campaign_(campaign), options_(options), result_(result) {
  note("fitting the geometry");
  result_.fit = calibrate(robot, campaign);
  declared_ = static_cast<int>(robot.effects.size());
  result_.stages.push_back(result_.fit);
  std::vector<Candidate> candidates = catalogue_candidates(catalogue, robot, campaign);
  if (options.beyond_catalogue) {
    const std::vector<Candidate> open = open_candidates(robot, campaign);
    const size_t known = candidates.size();
    for (const Candidate& candidate : open) candidates.push_back(candidate);
    // Whoever looks beyond the catalogue has looked at the catalogue too.
    for (size_t k = known; k < candidates.size(); ++k)
      candidates[k].log_choices =
          std::log(std::exp(candidates[k].log_choices) + static_cast<double>(known));
  }
  // Of candidates that explain alike the first is taken.
  std::sort(candidates.begin(), candidates.end(), comes_before);
  // Moments and forces are taken along the axes of R_A, so each base must be where it was.
  const Robot start = starting_robot(robot, campaign, result_.fit.set);
  scan_.emplace(candidates, start, in_common_frame(campaign, start));
  if (scan_->candidates().empty())
    throw std::invalid_argument(
        campaign.source +
        ": no effect of the catalogue can be looked for in these measurements, which lack the "
        "columns of its drivers (t_s, temp_..._c, payload_kg, fx_n, dir1, tau1_nm, ...); log "
        "them, take another catalogue or search beyond it (without --only-catalogue)");
}

void ModelSearch::run() {
  for (const Effect& effect : options_.start) begin_with(effect);
  if (!chosen_.empty()) {
    revise(KnownCauses::give_way);
    result_.stages.push_back(result_.fit);
  }
  // Beside effects that are still missing a curve takes up what they leave. So a known cause
  // gives way to a curve only when there is nothing left to add.
  bool may_revise = true;
  for (;;) {
    while (step()) {
      if (may_revise && chosen_.size() > 1) revise(KnownCauses::stay);
      merge_into_spline(kManyOfOnePlace);
      may_revise &= is_new_model();
      result_.stages.push_back(result_.fit);
    }
    if (!(may_revise && revise(KnownCauses::give_way)) && !merge_into_spline(2)) {
      if (fine_curves_) break;
      fine_curves_ = true;
      continue;
    }
    may_revise &= is_new_model();
    result_.stages.back() = result_.fit;
  }
  settle_inner_values();
  drop_idle();
}

// One forward step; false if nothing more is to be added.
bool ModelSearch::step() {
  note("scanning for effect " + std::to_string(chosen_.size() + 1));
  const auto& [fit, projected] = view();
  const std::vector<CandidateScore> scores = projected.scores();
  const std::vector<int> order = best_first(scores);
  rank(scores, order);
  result_.best_score = scores[order.front()].score;
  int trials = 0;
  for (int candidate : order) {
    if (scores[candidate].score <= 0 || trials == kTrials) break;
    if (!may_enter(scan_->candidates()[candidate])) continue;
    ++trials;
    if (!scan_->is_possible(candidate, scores[candidate].coefficients)) continue;
    const CrossValidation cv =
        CrossValidation::of(fit, projected.directions(candidate), options_.seed);
    if (cv.gain <= cv.error) continue;
    const double p = p_value(scores[candidate].score);
    if (p >= significance() || static_cast<int>(chosen_.size()) == options_.max_effects) {
      result_.remaining_p = p;
      return false;
    }
    add(candidate, p);
    return true;
  }
  result_.remaining_p = p_value(result_.best_score);
  return false;
}

void ModelSearch::rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order) {
  result_.ranking.clear();
  for (int candidate : order) {
    if (result_.ranking.size() == 20) break;
    const CandidateScore& score = scores[candidate];
    if (score.degrees_of_freedom == 0) break;
    result_.ranking.push_back(ranked(scan_->candidates()[candidate], score));
  }
  result_.not_separable.clear();
  for (size_t k = 0; k < scores.size(); ++k)
    if (scores[k].degrees_of_freedom == 0 && scan_->candidates()[k].from_catalogue &&
        !is_in_model(scan_->candidates()[k].effect))
      result_.not_separable.push_back(ranked(scan_->candidates()[k], scores[k]));
}

void ModelSearch::add(int candidate, double p) {
  p_at_gate_.push_back(p);
  chosen_.push_back(refine(scan_->candidates()[candidate], -1));
  refit({});
}

// Adds an effect that was asked for, whatever the gates say.
void ModelSearch::begin_with(const Effect& effect) {
  const auto& candidates = scan_->candidates();
  const auto found =
      std::find_if(candidates.begin(), candidates.end(),
                   [&](const Candidate& candidate) { return same_form(candidate.effect, effect); });
  if (found == candidates.end())
    throw std::invalid_argument(effect.parameter + " by " + to_string(effect.driver) +
                                " is no candidate of the search that is to begin with it");
  const int candidate = static_cast<int>(found - candidates.begin());
  // Nothing is added of which nothing shows.
  const CandidateScore score = view().projected.scores()[candidate];
  if (score.degrees_of_freedom > 0) add(candidate, p_value(score.score));
}

// Refits the geometry and all effects; `start` are coefficients to start from, else zero for new
// ones.
void ModelSearch::refit(const std::vector<Effect>& start) {
  Robot robot = result_.fit.robot;
  robot.effects.resize(declared_);
  for (size_t k = 0; k < chosen_.size(); ++k) {
    Effect effect = chosen_[k].effect;
    const auto& old = start.empty() ? result_.fit.robot.effects : start;
    const size_t place = static_cast<size_t>(declared_) + k;
    if (place < old.size() && same_form(old[place], effect))
      effect.coefficients = old[place].coefficients;
    if (effect.coefficients.empty())
      effect.coefficients.resize(
          BoundEffect(effect, robot, campaign_.temperature_names).coefficient_count());
    robot.effects.push_back(effect);
  }
  CalibrationOptions options;
  options.start_near(result_.fit);
  options.tolerance = kSearchTolerance;
  result_.fit = calibrate(robot, campaign_, result_.fit.set, options);
  view_.reset();
  null_scores_.clear();
}

// The same candidate with its inner values (t*, tau) where they explain most, beside all that is
// in the model or, if `effect` is not negative, in the place of that effect.
Candidate ModelSearch::refine(const Candidate& found, int effect) {
  const std::vector<Candidate> finer = refined_candidates(found, campaign_);
  if (finer.empty()) return found;
  return finer[best_first(scores_of(finer, effect)).front()];
}

std::vector<CandidateScore> ModelSearch::scores_of(const std::vector<Candidate>& candidates,
                                                   int effect) {
  const Robot& robot = result_.fit.robot;
  const CandidateScan scan(candidates, robot, in_common_frame(campaign_, robot));
  const ProjectedCandidates projected(scan, view().fit);
  return effect < 0 ? projected.scores() : projected.scores_without({effect});
}

// Drops effects that the others have made idle, and exchanges those that another now explains
// better. False if nothing changed.
bool ModelSearch::revise(KnownCauses known_causes) {
  int round = 0;
  while (round < kRevisions && !chosen_.empty() && revise_one(known_causes)) ++round;
  return round > 0;
}

// The one change that lowers EBIC most, so that it does not matter which effect came first.
bool ModelSearch::revise_one(KnownCauses known_causes) {
  const ProjectedCandidates& projected = view().projected;
  int effect = -1;
  std::optional<Candidate> other;
  double most = 0;
  for (size_t k = 0; k < chosen_.size(); ++k) {
    const double own = score_of({static_cast<int>(k)}).score;
    const std::vector<CandidateScore> scores = projected.scores_without({in_fit(k)});
    const bool by_known = chosen_[k].from_catalogue && known_causes == KnownCauses::stay;
    const auto better = better_than(std::max(own, 0.0), scores, by_known);
    const double fall = better ? scores[*better].score - own : -own;
    if (fall < most || (!better && own > 0)) continue;
    std::optional<Candidate> refined;
    if (better) refined = refine(scan_->candidates()[*better], in_fit(k));
    if (refined && same_form(refined->effect, chosen_[k].effect)) continue;
    most = fall;
    effect = static_cast<int>(k);
    other = refined;
  }
  if (effect < 0) return false;
  std::vector<Effect> coefficients = result_.fit.robot.effects;
  if (other) {
    chosen_[effect] = *other;
    p_at_gate_[effect] = std::nullopt;
    coefficients[in_fit(effect)] = {};
  } else {
    remove({effect}, coefficients);
  }
  refit(coefficients);
  return true;
}

// The best possible candidate, `known` or any, that is clearly better than `score`.
std::optional<int> ModelSearch::better_than(double score, const std::vector<CandidateScore>& scores,
                                            bool known) const {
  for (int candidate : best_first(scores)) {
    if (scores[candidate].score <= score + kClearlyBetter) break;
    const Candidate& other = scan_->candidates()[candidate];
    if ((other.from_catalogue || !known) && may_enter(other) &&
        scan_->is_possible(candidate, scores[candidate].coefficients))
      return candidate;
  }
  return std::nullopt;
}

CandidateScore ModelSearch::score_of(const std::vector<int>& chosen) {
  std::vector<int> effects;
  double log_choices = 0;
  for (int k : chosen) {
    effects.push_back(in_fit(static_cast<size_t>(k)));
    log_choices += chosen_[k].log_choices;
  }
  return view().projected.score_of(effects, chosen_[chosen.front()].effect.parameter, log_choices);
}

// `least` or more effects of one parameter and driver give way to one fine curve where it
// explains more than they do together. False if nothing changed.
bool ModelSearch::merge_into_spline(size_t least) {
  std::vector<int> merged;
  int curve = -1;
  double most = kClearlyBetter;
  for (size_t first = 0; first < chosen_.size(); ++first) {
    std::vector<int> together, effects;
    for (size_t k = first; k < chosen_.size(); ++k)
      if (same_place(chosen_[k].effect, chosen_[first].effect)) {
        together.push_back(static_cast<int>(k));
        effects.push_back(in_fit(k));
      }
    const bool seen = std::any_of(chosen_.begin(), chosen_.begin() + first, [&](const auto& c) {
      return same_place(c.effect, chosen_[first].effect);
    });
    if (together.size() < least || seen) continue;
    const double own = score_of(together).score;
    const std::vector<CandidateScore> scores = view().projected.scores_without(effects);
    for (size_t c = 0; c < scores.size(); ++c) {
      const Candidate& candidate = scan_->candidates()[c];
      if (!candidate.fine || !same_place(candidate.effect, chosen_[first].effect) ||
          scores[c].score <= own + most)
        continue;
      most = scores[c].score - own;
      merged = together;
      curve = static_cast<int>(c);
    }
  }
  if (curve < 0 || ++merges_ > kMaxMerges) return false;
  std::vector<Effect> coefficients = result_.fit.robot.effects;
  remove(merged, coefficients);
  chosen_.push_back(scan_->candidates()[curve]);
  p_at_gate_.push_back(std::nullopt);
  refit(coefficients);
  return true;
}

// Inner values were chosen beside what was in the model then; now beside all.
void ModelSearch::settle_inner_values() {
  for (int round = 0; round < kSettlings; ++round) {
    std::vector<Candidate> settled;
    for (size_t k = 0; k < chosen_.size(); ++k) settled.push_back(refine(chosen_[k], in_fit(k)));
    if (std::equal(
            settled.begin(), settled.end(), chosen_.begin(),
            [](const Candidate& a, const Candidate& b) { return same_form(a.effect, b.effect); }))
      return;
    chosen_ = settled;
    refit({});
    result_.stages.back() = result_.fit;
  }
}

// Some stood for what the inner values of others missed.
void ModelSearch::drop_idle() {
  for (;;) {
    int idle = -1;
    double least = 0;
    for (int k = 0; k < static_cast<int>(chosen_.size()); ++k) {
      const double score = score_of({k}).score;
      if (score > least) continue;
      least = score;
      idle = k;
    }
    if (idle < 0) return;
    std::vector<Effect> coefficients = result_.fit.robot.effects;
    remove({idle}, coefficients);
    refit(coefficients);
    result_.stages.back() = result_.fit;
  }
}

// From the chosen; `indices` ascend.
void ModelSearch::remove(const std::vector<int>& indices, std::vector<Effect>& coefficients) {
  for (auto k = indices.rbegin(); k != indices.rend(); ++k) {
    chosen_.erase(chosen_.begin() + *k);
    p_at_gate_.erase(p_at_gate_.begin() + *k);
    coefficients.erase(coefficients.begin() + declared_ + *k);
  }
}

void ModelSearch::put_in_order(const std::vector<size_t>& order) {
  if (std::is_sorted(order.begin(), order.end())) return;
  const std::vector<Candidate> chosen = chosen_;
  const auto p_at_gate = p_at_gate_;
  std::vector<Effect> in_order = result_.fit.robot.effects;
  for (size_t k = 0; k < order.size(); ++k) {
    chosen_[k] = chosen[order[k]];
    p_at_gate_[k] = p_at_gate[order[k]];
    in_order[in_fit(k)] = result_.fit.robot.effects[in_fit(order[k])];
  }
  refit(in_order);
  result_.stages.back() = result_.fit;
}

// Adding and dropping may not go round in circles: once a model comes back, what is in stays, and
// after so many models too, for frequencies seldom come back to the last digit.
bool ModelSearch::is_new_model() {
  std::multiset<std::string> names;  // whatever their order; inner values do not count
  for (const Candidate& candidate : chosen_)
    names.insert(candidate.effect.parameter + "|" + to_string(candidate.effect.driver) + "|" +
                 to_string(candidate.effect.shape));
  return seen_.insert(names).second && seen_.size() < kMaxModels;
}

double ModelSearch::p_value(double score) {
  const double level = significance();
  double p = 1;
  for (int flips : {options_.flips, 10 * options_.flips}) {
    if (static_cast<int>(null_scores_.size()) < flips)
      null_scores_ = view().projected.best_of_flipped(flips, options_.seed);
    const auto as_high = std::count_if(null_scores_.begin(), null_scores_.end(),
                                       [&](double by_chance) { return by_chance >= score; });
    p = (1.0 + static_cast<double>(as_high)) / (1.0 + static_cast<double>(null_scores_.size()));
    // More draws only where these cannot tell.
    if (p >= options_.significance || p < level) break;
  }
  describe_null_run(level);
  return p;
}

// What would have been added where nothing is: draws whose best candidate passes the gates.
void ModelSearch::describe_null_run(double level) {
  std::vector<double> scores = null_scores_;
  std::sort(scores.begin(), scores.end(), std::greater<>());
  const auto count = static_cast<double>(scores.size());
  NullRun& run = result_.null_run;
  run.flips = static_cast<int>(scores.size());
  run.score_95 = scores[static_cast<size_t>(0.05 * count)];
  int added = 0;
  for (size_t k = 0; k < scores.size(); ++k)
    added += scores[k] > 0 && static_cast<double>(k + 1) / (1.0 + count) < level;
  run.false_add_rate = added / count;
}

double ModelSearch::significance() const {
  return significance_level(result_.fit, campaign_, options_.significance,
                            options_.significance_without_lack_of_fit);
}

bool ModelSearch::may_enter(const Candidate& candidate) const {
  return (fine_curves_ || !candidate.fine) && !is_in_model(candidate.effect);
}

bool ModelSearch::is_in_model(const Effect& effect) const {
  const auto& effects = result_.fit.robot.effects;
  return std::any_of(effects.begin(), effects.end(),
                     [&](const Effect& other) { return same_form(other, effect); });
}

const ModelSearch::View& ModelSearch::view() {
  if (!view_) view_ = std::make_unique<View>(*scan_, result_.fit, campaign_);
  return *view_;
}

void ModelSearch::note(const std::string& what) const {
  if (options_.progress) options_.progress(what);
}

}  // namespace armtrue
