#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/refit.h"
#include "armtrue/effects/robot_model.h"
#include "search/cross_validation.h"
#include "search/evidence.h"
#include "search/search_phases.h"

namespace armtrue {
namespace {

// Inner values converge in one or two rounds.
constexpr int kMaxSettlings = 2;

}  // namespace

// Refines inner values (t*, tau, frequency) beside all effects; until now each was chosen beside
// the effects before it only.
void ModelSearch::settle_inner_values() {
  settle_inner_values([](const Candidate&) { return true; }, 0);
}

// The same between the steps of a search, where effects share the place of one. A further effect
// would compensate an error of the first: two cycles of a gear train whose frequencies are off by a
// hundredth look like three.
void ModelSearch::settle_place_of(int chosen) {
  const Effect effect = model_.chosen()[chosen].effect;
  const auto is_there = [&](const Candidate& other) { return same_place(other.effect, effect); };
  if (std::ranges::count_if(model_.chosen(), is_there) > 1)
    settle_inner_values(is_there, kMinFallToExchange);
}

// Of effects that are asked for; `least`: fall of EBIC for which they are changed.
void ModelSearch::settle_inner_values(const std::function<bool(const Candidate&)>& asked,
                                      double least) {
  for (int round = 0; round < kMaxSettlings; ++round) {
    const std::vector<Candidate>& chosen = model_.chosen();
    std::vector<Candidate> settled = chosen;
    bool changed = false;
    for (int k = 0; k < model_.chosen_count(); ++k) {
      if (!asked(chosen[k])) continue;
      const auto best = model_.with_best_inner_values(chosen[k], model_.in_fit(k));
      if (!best || same_form(best->candidate.effect, chosen[k].effect)) continue;
      if (least > 0 && best->score < model_.score_of({k}).score + least) continue;
      settled[k] = best->candidate;
      changed = true;
    }
    if (!changed) return;
    model_.settle(settled);
  }
}

// Drops effects that only compensated wrong inner values of others, and those with impossible
// coefficients beside the others.
void ModelSearch::drop_idle() {
  for (;;) {
    int idle = -1;
    double least = 0;
    for (int k = 0; k < model_.chosen_count(); ++k) {
      const double score = model_.score_of({k}).score;
      const bool impossible = !model_.is_allowed(k);
      if (score > least && !impossible) continue;
      least = std::min(least, score);
      idle = k;
      if (impossible) break;
    }
    if (idle < 0) return;
    model_.drop({idle});
  }
}

// Drops effects without which a refit is as good. The score of an effect is that of a linear
// problem. Along a direction that the readings hardly determine the model is not linear, and a
// refit of the constants may absorb the effect.
void ModelSearch::drop_by_refit() {
  for (int k = model_.chosen_count() - 1; k >= 0; --k)
    if (model_.refitted_score_of(k).score <= 0) {
      model_.drop({k});
      k = model_.chosen_count();
    }
}

// Where readings do not tell which member of a family errs, as the scales of two wires, one alone
// would take the difference of both, and the lengths of the arm its own part. If programs do not
// follow the family, because it is the instrument's, that part would be lost to them: all members
// that may err share what was found, under the prior of the family.
void ModelSearch::share_in_station() {
  for (int k = 0; k < model_.chosen_count(); ++k) {
    const Candidate found = model_.chosen()[k];
    if (!found.effect.members.empty() || !moves_reading_alone(owner_of(found.effect))) continue;
    const auto is_found = [&](const Effect& effect) { return same_form(effect, found.effect); };
    const auto family = std::ranges::find_if(candidates(), [&](const Candidate& candidate) {
      return std::ranges::any_of(candidate.effect.members, is_found);
    });
    if (family == candidates().end()) continue;
    Candidate shared = *family;
    std::vector<Candidate> alone;
    for (const Effect& member : shared.effect.members)
      alone.push_back(*std::ranges::find_if(candidates(), [&](const Candidate& candidate) {
        return same_form(candidate.effect, member);
      }));
    const std::vector<CandidateScore> scores = model_.scores_of(alone, model_.in_fit(k));
    const double least = model_.score_of({k}).score - kRuledOut;
    size_t member = 0;
    std::erase_if(shared.effect.members, [&](const Effect& effect) {
      const double score = scores[member++].score;
      return !is_found(effect) && (score < least || model_.contains(effect));
    });
    if (shared.effect.members.size() < 2) continue;
    shared_.insert(found.of_family);
    model_.exchange(k, shared);
  }
}

// Members of a family with evidence of their own become findings. The others stay in the model,
// held by their common prior, if there is evidence for all of them together.
void ModelSearch::split_families() {
  if (!model_.split_families()) return;
  std::set<std::string> families;
  for (const Candidate& candidate : model_.chosen())
    if (candidate.effect.family) families.insert(candidate.effect.family->name);
  for (const std::string& family : families) judge_members(family);
  for (CalibrationResult& stage : result_.stages) {
    std::vector<Effect> singles;
    for (const Effect& effect : stage.robot.effects)
      for (Effect& single : single_effects(effect)) singles.push_back(std::move(single));
    stage.robot.effects = std::move(singles);
  }
}

// If no member has evidence of its own, but all together have, the one with the most is the
// finding, and the others share it. So it is of the instrument's, too, where some have: the lengths
// of the arm depend on the parts.
void ModelSearch::judge_members(const std::string& family) {
  constexpr double kAic = 2;  // of the gain per coefficient, from which it predicts better with it
  for (;;) {
    std::vector<int> members, weak;
    std::map<int, double> scores;
    for (int k = 0; k < model_.chosen_count(); ++k) {
      const std::optional<Family>& own = model_.chosen()[k].effect.family;
      if (!own || own->name != family) continue;
      members.push_back(k);
      scores[k] = model_.score_of({k}).score;
      if (scores[k] <= 0) weak.push_back(k);
    }
    add_those_that_share(weak);
    if (weak.empty()) return;
    const CandidateScore together = model_.score_of_members(weak, {});
    const bool show_together =
        weak == members || moves_reading_alone(owner_of(model_.chosen()[weak.front()].effect));
    if (together.gain > kAic * together.degrees_of_freedom) {
      if (show_together && together.score > 0)
        weak.erase(std::ranges::max_element(weak, {}, [&](int k) { return scores[k]; }));
      model_.hold(weak);
      return;
    }
    model_.drop(weak);
  }
}

// A member without a direction of its own shares that of the others.
void ModelSearch::add_those_that_share(std::vector<int>& ascending) {
  std::set<std::string> shared;
  for (int k : ascending)
    if (const Candidate& weak = model_.chosen()[k];
        shared_.contains(weak.of_family) && model_.score_of({k}).degrees_of_freedom == 0)
      shared.insert(weak.of_family);
  for (int k = 0; k < model_.chosen_count(); ++k)
    if (shared.contains(model_.chosen()[k].of_family)) ascending.push_back(k);
  std::ranges::sort(ascending);
  ascending.erase(std::unique(ascending.begin(), ascending.end()), ascending.end());
}

// A family that most arms have needs no evidence to stay in the model, only none against it: its
// members stay with their common prior, unless they make the prediction of poses left out worse.
void ModelSearch::hold_family_of_most_arms() {
  const auto found = std::ranges::find_if(candidates(), [](const Candidate& candidate) {
    return candidate.of_most_arms && !candidate.effect.members.empty();
  });
  if (found == candidates().end()) return;
  Candidate family = *found;
  std::erase_if(family.effect.members,
                [&](const Effect& member) { return model_.contains(member); });
  if (family.effect.members.empty()) return;
  const Eigen::VectorXd without = errors_left_out(model_.fit().robot);
  if (!add_beside_found(family)) return;
  if (errors_left_out(model_.fit().robot).mean() > without.mean()) {
    model_.drop({model_.chosen_count() - 1});
    return;
  }
  std::vector<int> singles(model_.chosen().back().effect.members.size());
  model_.split_families();
  std::iota(singles.begin(), singles.end(), model_.chosen_count() - std::ssize(singles));
  model_.hold(singles);
}

// Adds a family without the members that would take directions from the effects that were found, as
// the compliance of an axis does that of an eccentricity: where masses are not known its torque is
// sine and cosine of the angle. False if no member is left.
bool ModelSearch::add_beside_found(Candidate family) {
  const int found = model_.chosen_count();
  const auto directions = [&] {
    std::vector<int> count;
    for (int k = 0; k < found; ++k) count.push_back(model_.score_of({k}).degrees_of_freedom);
    return count;
  };
  const std::vector<int> alone = directions();
  std::vector<Effect>& members = family.effect.members;
  while (!members.empty()) {
    model_.add(family, 1);
    const std::vector<int> beside = directions();
    const auto k = std::ranges::mismatch(alone, beside).in1 - alone.begin();
    if (k == found) return true;
    const Parameter& taken = model_.chosen()[k].effect.parameter;
    if (std::erase_if(members, [&](const Effect& member) { return member.parameter == taken; }) ==
        0)
      members.clear();
    model_.drop({found});
  }
  return false;
}

// Mean error of the position of each pose by a fit of the robot that has not seen it [m].
Eigen::VectorXd ModelSearch::errors_left_out(const Robot& robot) const {
  constexpr int kFolds = 10;
  constexpr int kKeepLaw = 1;  // a part of the readings has the law of all
  const CalibrationResult& fit = model_.fit();
  const std::vector<int> pose = campaign_.pose_by_id();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(std::ssize(campaign_.pose_ids)), weights = sums;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<int> inside, outside;
    for (int row = 0; row < campaign_.rows(); ++row)
      (pose[row] % kFolds == fold ? outside : inside).push_back(row);
    const CalibrationResult part =
        refit(robot, campaign_.select(inside), fit, kSearchTolerance, kKeepLaw);
    const Evaluation evaluation = evaluate(part.robot, campaign_.select(outside));
    for (size_t k = 0; k < outside.size(); ++k) {
      const double weight = fit.weights[outside[k]];
      sums[pose[outside[k]]] += weight * evaluation.position[k];
      weights[pose[outside[k]]] += weight;
    }
  }
  return sums.cwiseQuotient(weights.cwiseMax(1e-300));
}

}  // namespace armtrue
