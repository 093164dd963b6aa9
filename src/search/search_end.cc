#include <algorithm>
#include <utility>

#include "armtrue/calibration/evaluation.h"
#include "calibration/refit.h"
#include "search/search_phases.h"

namespace armtrue {
namespace {

// Inner values converge in one or two rounds.
constexpr int kMaxSettlings = 2;

}  // namespace

// Refines inner values (t*, tau, frequency) beside all effects; until now each was chosen beside
// the effects before it only.
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

// Drops effects that only compensated wrong inner values of others, and those that are impossible
// beside the others.
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

// Members of a family with evidence of their own become findings. If there is evidence for all the
// others together, they stay in the model with their common prior.
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

}  // namespace armtrue
