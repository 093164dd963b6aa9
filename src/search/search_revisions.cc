#include <algorithm>

#include "search/search_phases.h"

namespace armtrue {
namespace {

// Exchanges end after one or two rounds; beyond this bound they would repeat for ever.
constexpr int kMaxRevisions = 4;
constexpr int kMaxMerges = 50;  // several times what the longest search went through

bool is_in_time(const Effect& effect, ShapeKind shape) {
  return effect.driver.kind == DriverKind::time && !effect.driver.factor &&
         effect.shape.kind == shape;
}

}  // namespace

// Exchanges effects that another candidate now explains better, and drops effects that the others
// have made superfluous. False if nothing changed.
bool ModelSearch::revise(KnownCauses known_causes) {
  std::vector<EffectModel::Fitted> left;  // the models that were revised
  while (std::ssize(left) < kMaxRevisions && !model_.chosen().empty()) {
    const std::optional<Revision> revision = best_revision(known_causes);
    if (!revision) break;
    left.push_back(model_.fitted());
    const auto known = std::find_if(left.begin(), left.end(), [&](const auto& model) {
      return leads_to(*revision, model.chosen);
    });
    if (known != left.end()) {
      taken_back_.push_back({model_.chosen()[revision->effect].effect, revision->other->effect});
      // All further revisions repeat this cycle of models: stop where the last of them would end.
      const auto more = kMaxRevisions - (known - left.begin());
      model_.come_back(known[more % (left.end() - known)]);
      return true;
    }
    // Only the model to which a cycle of two returns keeps its view: views are large.
    if (left.size() > 1) left[left.size() - 2].forget_view();
    const int revised = revision->effect;
    if (revision->other) {
      model_.exchange(revised, *revision->other);
      if (is_half_shown(revised)) {
        barred_.insert(revision->other->effect.name);
        model_.come_back(left.back());
        left.pop_back();
        continue;
      }
      settle_place_of(revised);
    } else {
      model_.drop({revision->effect});
    }
  }
  return !left.empty();
}

// Whether a revision of the present model makes a model of these candidates.
bool ModelSearch::leads_to(const Revision& revision, const std::vector<Candidate>& chosen) const {
  if (!revision.other) return false;
  std::vector<Candidate> revised = model_.chosen();
  revised[revision.effect] = *revision.other;
  return std::ranges::equal(revised, chosen, [](const Candidate& a, const Candidate& b) {
    return same_form(a.effect, b.effect) &&
           std::ranges::equal(a.effect.members, b.effect.members, same_form);
  });
}

// Whether an exchange of the two led back to an earlier model. In the linear scan each looks better
// than the other, and would again with every added effect.
bool ModelSearch::was_taken_back(const Effect& a, const Effect& b) const {
  return std::ranges::any_of(taken_back_, [&](const auto& pair) {
    return (same_form(a, pair[0]) && same_form(b, pair[1])) ||
           (same_form(a, pair[1]) && same_form(b, pair[0]));
  });
}

// The one change that lowers EBIC most, so that the order of the additions does not matter.
std::optional<ModelSearch::Revision> ModelSearch::best_revision(KnownCauses known_causes) {
  const ProjectedCandidates& projected = model_.view().projected;
  const std::vector<Candidate>& chosen = model_.chosen();
  std::vector<std::vector<int>> each;
  for (int k = 0; k < model_.chosen_count(); ++k) each.push_back({model_.in_fit(k)});
  const std::vector<ProjectedCandidates::Place> places = projected.places_of(each);
  std::optional<Revision> best;
  double most = 0;
  for (int k = 0; k < model_.chosen_count(); ++k) {
    const double own = model_.score_of({k}, places[k].loss).score;
    const double least = std::max(own, 0.0) + kMinFallToExchange;
    const bool by_known = chosen[k].from_catalogue && known_causes == KnownCauses::stay;
    const std::vector<CandidateScore> scores =
        projected.scores_above(least, places[k], [&](int candidate) {
          const Candidate& other = candidates()[candidate];
          return (other.from_catalogue || !by_known) && may_enter(other);
        });
    const auto better = better_than(least, scores);
    double fall = better ? scores[*better].score - own : -own;
    std::optional<Candidate> refined;
    const double to_beat = std::max(least, own + fall);
    const std::optional<EffectModel::Refined> cycle = cycle_in_place_of(k, to_beat, places[k]);
    if (cycle && cycle->score > to_beat) {
      fall = cycle->score - own;
      refined = cycle->candidate;
    }
    if (fall < most || (!better && !refined && own > 0)) continue;
    if (better && !refined) refined = model_.refined(candidates()[*better], model_.in_fit(k));
    if (refined && same_form(refined->effect, chosen[k].effect)) continue;
    if (refined && known_causes == KnownCauses::stay &&
        was_taken_back(chosen[k].effect, refined->effect))
      continue;
    most = fall;
    best = {k, refined};
  }
  return best;
}

// The best cycle in the place of a curve of the same parameter and driver, if it could score more
// than `least`. Between two steps of the periodogram a clear cycle loses more than the coefficients
// of a curve cost, so the two are compared at the best frequency.
std::optional<EffectModel::Refined> ModelSearch::cycle_in_place_of(
    int curve, double least, const ProjectedCandidates::Place& place) {
  constexpr double kLostBetweenSteps = 0.1;  // of the gain, at most: 6 % by the amplitude
  const Candidate& chosen = model_.chosen()[curve];
  if (chosen.from_catalogue || chosen.frequency_resolution > 0) return std::nullopt;
  const auto is_cycle = [&](int candidate) {
    const Candidate& other = candidates()[candidate];
    return other.frequency_resolution > 0 && same_place(other.effect, chosen.effect) &&
           may_enter(other);
  };
  const std::vector<CandidateScore> scores =
      model_.view().projected.scores_above(0, place, is_cycle);
  const int best = best_first(scores).front();
  if (!is_cycle(best) || scores[best].score + kLostBetweenSteps * scores[best].gain <= least)
    return std::nullopt;
  return model_.with_best_inner_values(candidates()[best], model_.in_fit(curve));
}

// The best candidate of possible size that scores more than `least`.
std::optional<int> ModelSearch::better_than(double least,
                                            const std::vector<CandidateScore>& scores) const {
  for (int candidate : best_first(scores)) {
    if (scores[candidate].score <= least) break;
    if (model_.scan().is_possible(candidate, scores[candidate].coefficients)) return candidate;
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
  for (int first = 0; first < model_.chosen_count(); ++first) {
    std::vector<int> together, effects;
    for (int k = first; k < model_.chosen_count(); ++k)
      if (same_place(chosen[k].effect, chosen[first].effect)) {
        together.push_back(k);
        effects.push_back(model_.in_fit(k));
      }
    const bool seen = std::any_of(chosen.begin(), chosen.begin() + first, [&](const auto& c) {
      return same_place(c.effect, chosen[first].effect);
    });
    if (together.size() < least || seen) continue;
    const double own = model_.score_of(together).score;
    const std::vector<CandidateScore> scores =
        model_.view().projected.scores_above(own + most, effects, [&](int candidate) {
          const Candidate& other = candidates()[candidate];
          return other.fine && same_place(other.effect, chosen[first].effect);
        });
    for (size_t c = 0; c < scores.size(); ++c) {
      if (scores[c].score <= own + most) continue;
      most = scores[c].score - own;
      merged = together;
      curve = static_cast<int>(c);
    }
  }
  if (curve < 0 || ++merges_ > kMaxMerges) return false;
  model_.merge(merged, candidates()[curve]);
  return true;
}

// Replaces a curve of time by steps of the same parameter where EBIC prefers these. What jumps one
// way and later the other looks like a curve as long as one step at a time is tried. False if
// nothing changed.
bool ModelSearch::part_into_steps() {
  constexpr size_t kMostSteps = 3;  // more are no events
  const auto found = std::ranges::find_if(model_.chosen(), [&](const Candidate& chosen) {
    return is_in_time(chosen.effect, ShapeKind::series) &&
           !parted_.contains(to_string(chosen.effect.parameter));
  });
  if (found == model_.chosen().end()) return false;
  const Effect curve = found->effect;
  parted_.insert(to_string(curve.parameter));
  const auto all_there = [&] {
    std::vector<int> there;
    for (int k = 0; k < model_.chosen_count(); ++k)
      if (same_place(model_.chosen()[k].effect, curve)) there.push_back(k);
    return there;
  };
  const auto best_step = [&](const std::vector<CandidateScore>& scores) {
    int best = -1;
    for (int c = 0; c < std::ssize(candidates()); ++c)
      if (is_in_time(candidates()[c].effect, ShapeKind::step) && may_enter(candidates()[c]) &&
          same_place(candidates()[c].effect, curve) &&
          (best < 0 || scores[c].score > scores[best].score))
        best = c;
    return best;
  };
  const EffectModel::Fitted before = model_.fitted();
  const double own = model_.score_of(all_there()).score;
  const auto k = static_cast<int>(found - model_.chosen().begin());
  const int first = best_step(model_.view().projected.scores_without({model_.in_fit(k)}));
  if (first < 0) return false;
  model_.exchange(k, model_.refined(candidates()[first], model_.in_fit(k)));
  while (all_there().size() < kMostSteps) {
    const std::vector<CandidateScore> scores = model_.view().projected.scores();
    const int next = best_step(scores);
    if (next < 0 || scores[next].score <= 0) break;
    model_.add(model_.refined(candidates()[next], -1), model_.chance_of(scores[next].score));
    settle_place_of(model_.chosen_count() - 1);
  }
  if (model_.score_of(all_there()).score > own + kMinFallToExchange) return true;
  model_.come_back(before);
  return false;
}

}  // namespace armtrue
