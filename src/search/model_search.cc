#include "search/model_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/statistics/distributions.h"
#include "search/cross_validation.h"
#include "search/evidence.h"
#include "search/search_phases.h"

namespace armtrue {
namespace {

// This many effects of one parameter and driver are taken as parts of one curve; two may be two
// real effects.
constexpr size_t kMinPiecesOfCurve = 3;
constexpr size_t kMaxModels = 100;  // several times what the longest search went through
constexpr int kMaxTrials = 8;       // candidates of one step that may fail the later gates
constexpr size_t kMaxRanked = 20;

// A load moves each axis by its mass, its torque per kg and the compliance of the axis. p of the
// ratios among the members of a family that follow the weight of the tool against those of the
// compliances in the model, at the likeliest mass.
bool may_be_one_mass(const Robot& robot, const Effect& family) {
  constexpr double kSurely = 1e-3;
  struct Axis {
    double load, load_std, compliance, compliance_std;
  };
  std::vector<Axis> axes;
  for (size_t m = 0; m < family.members.size(); ++m) {
    const Effect& member = family.members[m];
    if (member.driver.factor != DriverKind::tool_weight) return true;
    const auto bends = std::ranges::find_if(robot.effects, [&](const Effect& other) {
      return other.parameter == member.parameter && other.coefficients.size() == 1 &&
             other.driver == Driver{DriverKind::gravity_torque, member.driver.second_joint, -1, ""} &&
             other.shape.kind == ShapeKind::linear;
    });
    if (bends == robot.effects.end()) continue;
    const Coefficient &load = family.coefficients[m], &compliance = bends->coefficients.front();
    axes.push_back({load.value, load.std, compliance.value, compliance.std});
  }
  if (axes.size() < 2) return true;
  const auto weight = [](const Axis& axis, double mass) {
    return 1 / (std::pow(axis.load_std, 2) +
                std::pow(mass, 2) * (std::pow(axis.compliance_std, 2) +
                                     std::pow(kMassesOff * axis.compliance, 2)) +
                1e-300);
  };
  double mass = 0;
  for (int round = 0; round < 10; ++round) {  // the weights depend on the mass
    double product = 0, square = 0;
    for (const Axis& axis : axes) {
      product += weight(axis, mass) * axis.load * axis.compliance;
      square += weight(axis, mass) * axis.compliance * axis.compliance;
    }
    mass = product / std::max(1e-300, square);
  }
  double chi_squared = 0;
  for (const Axis& axis : axes)
    chi_squared += weight(axis, mass) * std::pow(axis.load - mass * axis.compliance, 2);
  return chi_squared < chi_squared_quantile_above(kSurely, static_cast<double>(axes.size() - 1));
}

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
  do {
    find_effects();
    if (add_event()) find_effects();
    if (add_by_least_squares()) find_effects();
    const int found = model_.chosen_count();
    settle_inner_values();
    drop_idle();
    drop_by_refit();
    if (model_.chosen_count() < found) note_rest();
  } while (drop_half_shown());
  share_in_station();
  split_families();
  hold_family_of_most_arms();
  if (std::optional<CalibrationResult> geometry = model_.settle_tool())
    result_.stages.front() = *std::move(geometry);
  end_last_stage();
}

// Steps and revisions until nothing is left to add.
void ModelSearch::find_effects() {
  // While effects are missing, a curve also explains part of them. So a curve replaces a known
  // cause only when nothing is left to add.
  bool may_revise = true;
  for (;;) {
    while (step()) {
      if (may_revise && model_.chosen().size() > 1) revise(KnownCauses::stay);
      merge_into_spline(kMinPiecesOfCurve);
      may_revise &= is_new_model();
      result_.stages.push_back(model_.fit());
    }
    if (!(may_revise && revise(KnownCauses::give_way)) && !merge_into_spline(2) &&
        !part_into_steps()) {
      if (details_) {
        judge_rest();
        break;
      }
      details_ = true;
      continue;
    }
    may_revise &= is_new_model();
    result_.stages.back() = model_.fit();
  }
}

// Beside later effects, a family whose members occur together may no longer show, or not as an
// event. It does not come back.
bool ModelSearch::drop_half_shown() {
  std::vector<int> half_shown;
  for (int k = 0; k < model_.chosen_count(); ++k)
    if (is_half_shown(k)) {
      half_shown.push_back(k);
      rejected_.insert(model_.chosen()[k].effect.name);
    }
  if (half_shown.empty()) return false;
  model_.drop(half_shown);
  return true;
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
  failed_at_gate_ = false;
  int trials = 0;
  std::optional<CrossValidation> left_out;
  for (int candidate : order) {
    if (scores[candidate].score <= 0 || trials == kMaxTrials) break;
    // A family whose members occur together explains a part of nearly everything: it may only
    // replace found effects.
    if (!may_enter(candidates()[candidate]) || candidates()[candidate].only_together) continue;
    ++trials;
    if (!model_.scan().is_possible(candidate, scores[candidate].coefficients)) continue;
    if (!left_out) left_out.emplace(fit, options_.seed);
    const GainLeftOut cv = left_out->of(projected.directions(candidate));
    if (cv.gain <= cv.error) continue;
    const double p = model_.chance_of(scores[candidate].score);
    if (p >= model_.significance() || model_.chosen_count() == options_.max_effects) {
      result_.remaining_p = p;
      failed_at_gate_ = true;
      return false;
    }
    model_.add(model_.refined(candidates()[candidate], -1), p);
    barred_.clear();
    settle_place_of(model_.chosen_count() - 1);
    return true;
  }
  return false;
}

// An event that bends a link moves all parameters of that link at once, and may show in none of
// them alone. Where readings lack something and no effect could be added, the likeliest event
// enters if it leaves nothing but noise: a family explains a part of nearly everything, but not all
// of it.
bool ModelSearch::add_event() {
  if (model_.chosen_count() > 0 || options_.max_effects == 0) return false;
  if (assess(model_.fit(), campaign_).leaves_noise() != false) return false;
  const std::vector<CandidateScore> scores = model_.view().projected.scores();
  const EffectModel::Fitted before = model_.fitted();
  int trials = 0;
  for (int candidate : best_first(scores)) {
    if (scores[candidate].score <= 0 || trials == kMaxTrials) break;
    const Candidate& event = candidates()[candidate];
    if (!event.only_together || !event.effect.driver.follows_course() || !may_enter(event))
      continue;
    ++trials;
    if (!model_.scan().is_possible(candidate, scores[candidate].coefficients)) continue;
    const double p = model_.chance_of(scores[candidate].score);
    if (p >= model_.significance()) break;
    model_.add(model_.refined(event, -1), p);
    settle_place_of(0);
    if (!is_half_shown(0) && assess(model_.fit(), campaign_).leaves_noise() == true) {
      result_.stages.push_back(model_.fit());
      return true;
    }
    model_.come_back(before);
  }
  return false;
}

// An effect that moves a minority of the readings, such as those under a load, has heavy tails as
// long as it is not in the model: under Student's law these readings hardly count, and the effect
// does not show. Where readings lack something and no effect could be added, one enters by least
// squares if it shows under the law of the readings, too, once it is in the model.
bool ModelSearch::add_by_least_squares() {
  if (options_.max_effects == 0 || model_.fit().degrees_of_freedom <= 0) return false;
  if (assess(model_.fit(), campaign_).leaves_noise() != false) return false;
  const EffectModel::Fitted before = model_.fitted();
  const double p = result_.remaining_p;
  const bool failed_at_gate = failed_at_gate_;
  model_.fit_by_least_squares(true);
  const bool added = step();
  model_.fit_by_least_squares(false);
  if (added && model_.score_of({model_.chosen_count() - 1}).score > 0) {
    result_.stages.push_back(model_.fit());
    return true;
  }
  model_.come_back(before);
  const std::vector<CandidateScore> scores = model_.view().projected.scores();
  rank(scores, best_first(scores));
  result_.remaining_p = p;
  failed_at_gate_ = failed_at_gate;
  return false;
}

// What the present model leaves, after effects were dropped at the end.
void ModelSearch::note_rest() {
  const std::vector<CandidateScore> scores = model_.view().projected.scores();
  rank(scores, best_first(scores));
  failed_at_gate_ = false;
  judge_rest();
}

// Whether the best candidate that is left is more than chance.
void ModelSearch::judge_rest() {
  if (!failed_at_gate_) result_.remaining_p = model_.chance_of(result_.best_score);
  result_.pattern_remains = result_.best_score > 0 && result_.remaining_p < model_.significance();
  result_.null_run = model_.null_run();
}

void ModelSearch::rank(const std::vector<CandidateScore>& scores, const std::vector<int>& order) {
  result_.best_score = scores[order.front()].score;
  result_.ranking.clear();
  for (int candidate : order) {
    if (result_.ranking.size() == kMaxRanked) break;
    const CandidateScore& score = scores[candidate];
    if (!candidates()[candidate].effect.members.empty()) continue;  // its members are ranked
    if (!may_be_alone(candidates()[candidate])) continue;
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

// Whether the event of a chosen family may as well be that of the station or of the tool, which are
// moved more often than an arm is bent: not excluded by odds of 1000 to 1.
bool ModelSearch::may_be_knock(int k) {
  const double least = model_.score_of({k}).score - kRuledOut;
  const DriverKind driver = model_.chosen()[k].effect.driver.kind;
  const std::vector<CandidateScore> scores = model_.view().projected.scores_above(
      least, std::vector<int>{model_.in_fit(k)}, [&](int candidate) {
        const Effect& other = candidates()[candidate].effect;
        return moved_by(other) != Moved::arm && other.driver.kind == driver;
      });
  return std::ranges::any_of(scores,
                             [&](const CandidateScore& score) { return score.score > least; });
}

// Whether a chosen family whose effects occur together shows in too few of them, or, as an event,
// at no time. For a load, the common sign and the ratio of the compliances are evidence for the
// weaker axes, too.
bool ModelSearch::is_half_shown(int k) {
  // Of the readings. The time of a step that is just clear enough to be found (a fall of 30) lies
  // within 11 / (4 * 30) of the readings (Hansen, Econometrica 68, 2000); what takes longer is no
  // event.
  constexpr double kOneTime = 0.1;
  const Candidate& chosen = model_.chosen()[k];
  if (!chosen.only_together) return false;
  const int least = chosen.alike ? 1 : 2;
  if (chosen.effect.members.size() < 2 || model_.members_shown(k) < least) return true;
  if (!may_be_one_mass(model_.fit().robot, model_.fit().robot.effects[model_.in_fit(k)])) return true;
  if (chosen.effect.driver.kind == DriverKind::session) return may_be_knock(k);
  const std::optional<std::array<double, 2>> at = step_ci95(model_, campaign_, k);
  if (!at || chosen.effect.driver.kind != DriverKind::time) return false;
  if (may_be_knock(k)) return true;
  const auto within = std::ranges::count_if(campaign_.time_s,
                                            [&](double t) { return t > (*at)[0] && t < (*at)[1]; });
  return static_cast<double>(within) > kOneTime * campaign_.rows();
}

bool ModelSearch::may_enter(const Candidate& candidate) const {
  return (details_ || !candidate.detail) && may_be_alone(candidate) &&
         (options_.instrument_may_err || !is_lasting_of_instrument(candidate.effect)) &&
         !barred_.contains(candidate.effect.name) && !rejected_.contains(candidate.effect.name) &&
         !model_.contains(candidate.effect);
}

SearchResult search_effects(const Robot& robot, const Campaign& campaign,
                            const Catalogue& catalogue, const TraceOptions& options) {
  ModelSearch search(robot, campaign, catalogue, options);
  search.run();
  return search.take();
}

}  // namespace armtrue
