// The family-wise p of the scores of an EffectModel, by sign flips.

#include <algorithm>
#include <functional>
#include <vector>

#include "search/effect_model.h"
#include "search/significance.h"

namespace armtrue {
namespace {

// A few draws come before the others of a null run.
constexpr int kFewFlips = 20;

// Whether a score is so far above a few draws that many more would not reach it either. Sums with
// random signs fall off at least as those of a normal law, so the best scores of the draws fall off
// exponentially: by 1 / e for each third of the range of twenty, or for each 2 of EBIC.
bool is_far_beyond(double score, const std::vector<double>& draws) {
  constexpr double kRanges = 5, kScaleOfChance = 2;
  const auto [least, most] = std::ranges::minmax(draws);
  return score > most + kRanges * std::max(kScaleOfChance, most - least);
}

}  // namespace

double EffectModel::significance() {
  if (!significance_)
    significance_ = significance_level(fit_, campaign_, options_.significance,
                                       options_.significance_without_lack_of_fit);
  return *significance_;
}

double EffectModel::chance_of(double score) {
  const double level = significance();
  const auto p_of = [](auto as_high, auto draws) {
    return (1.0 + static_cast<double>(as_high)) / (1.0 + static_cast<double>(draws));
  };
  const int many = 10 * options_.flips;
  draw_null_scores(std::min(kFewFlips, options_.flips));
  if (is_far_beyond(score, null_scores_)) {
    const double p = p_of(0, options_.flips);
    return p < level ? p : p_of(0, many);
  }
  double p = 1;
  for (int flips : {options_.flips, many}) {
    draw_null_scores(flips);
    p = p_of(
        std::ranges::count_if(null_scores_, [&](double by_chance) { return by_chance >= score; }),
        null_scores_.size());
    // More draws matter only between the two levels.
    if (p >= options_.significance || p < level) break;
  }
  return p;
}

void EffectModel::draw_null_scores(int flips) {
  if (static_cast<int>(null_scores_.size()) < flips)
    null_scores_ = view().projected.best_of_flipped(flips, options_.seed);
}

// A draw adds an effect if its best candidate passes the criteria of EBIC and of p.
NullRun EffectModel::null_run() {
  const double level = significance();
  draw_null_scores(options_.flips);
  std::vector<double> scores = null_scores_;
  std::sort(scores.begin(), scores.end(), std::greater<>());
  const auto count = static_cast<double>(scores.size());
  NullRun run;
  run.flips = static_cast<int>(scores.size());
  run.score_95 = scores[static_cast<size_t>(0.05 * count)];
  int added = 0;
  for (size_t k = 0; k < scores.size(); ++k)
    added += scores[k] > 0 && static_cast<double>(k + 1) / (1.0 + count) < level;
  run.false_add_rate = added / count;
  return run;
}

}  // namespace armtrue
