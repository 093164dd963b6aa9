#include "armtrue/tracing/nested_validation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/campaign/without_rows.h"
#include "statistics/ordered_blocks.h"
#include "statistics/shuffle.h"
#include "tracing/rows_at_steps.h"

namespace armtrue {
namespace {

// The outer fold of every row.
std::vector<int> outer_folds(const Campaign& campaign, int folds, std::uint64_t seed) {
  const std::vector<int> pose = campaign.pose_by_id();
  std::map<int, int> session_of_pose;
  for (int row = 0; row < campaign.rows(); ++row)
    session_of_pose.try_emplace(pose[row], campaign.session.empty() ? 0 : campaign.session[row]);
  if (folds < 2 || folds > static_cast<int>(session_of_pose.size()))
    throw std::invalid_argument(
        "nested cross-validation: " + std::to_string(session_of_pose.size()) +
        " poses do not make " + std::to_string(folds) + " folds; ask for 2 to as many as poses");
  std::vector<int> poses;
  for (const auto& [number, session] : session_of_pose) poses.push_back(number);
  shuffle(poses, seed);
  std::stable_sort(poses.begin(), poses.end(),
                   [&](int a, int b) { return session_of_pose[a] < session_of_pose[b]; });
  std::map<int, int> fold_of_pose;
  for (size_t i = 0; i < poses.size(); ++i) fold_of_pose[poses[i]] = static_cast<int>(i) % folds;
  std::vector<int> fold_of_row;
  for (int number : pose) fold_of_row.push_back(fold_of_pose[number]);
  return fold_of_row;
}

FoldMean mean_over(const std::vector<double>& folds) {
  const double n = static_cast<double>(folds.size());
  if (n < 2) return {folds.empty() ? 0 : folds.front(), 0};
  double mean = 0, squares = 0;
  for (double value : folds) mean += value / n;
  for (double value : folds) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

bool has_in_class(const TracedEffect& traced, const Effect& effect) {
  return same_place(traced.effect, effect) ||
         std::any_of(traced.indistinguishable.begin(), traced.indistinguishable.end(),
                     [&](const Rival& rival) { return same_place(rival.effect, effect); });
}

}  // namespace

NestedValidation nested_validation(const Robot& robot, const Campaign& campaign,
                                   const Catalogue& catalogue, int folds,
                                   const std::vector<TracedEffect>& found,
                                   const TraceOptions& options) {
  const std::vector<int> fold_of_row = outer_folds(campaign, folds, options.seed);
  TraceOptions of_fold = options;
  of_fold.progress = nullptr;  // folds run side by side
  NestedValidation nested;
  nested.folds = folds;
  nested.found_again.resize(found.size());
  std::vector<double> before, after, gain;
  struct OuterFold {
    double before = 0, after = 0;  // mean error of the poses left out
    std::vector<TracedEffect> effects;
    bool is_judged = true;  // not if all its readings lie at a step
  };
  for_ordered_blocks<OuterFold>(
      folds, 1,
      [&](int fold, int) {
        std::vector<int> inside, outside;
        for (int row = 0; row < campaign.rows(); ++row)
          (fold_of_row[row] == fold ? outside : inside).push_back(row);
        const Campaign training = campaign.select(inside), held_out = campaign.select(outside);
        require_known_sessions(training, held_out);
        const TraceResult found_here = trace(robot, training, catalogue, of_fold);
        const Campaign judged =
            without_rows(held_out, rows_at_steps(found_here, training, held_out));
        return OuterFold{mean_reading_error(found_here.stages.front().robot, judged),
                         mean_reading_error(found_here.fit.robot, judged), found_here.effects,
                         judged.rows() > 0};
      },
      [&](const OuterFold& result) {
        if (result.is_judged) {
          before.push_back(result.before);
          after.push_back(result.after);
          gain.push_back(result.before - result.after);
        }
        for (size_t k = 0; k < found.size(); ++k)
          nested.found_again[k] += std::any_of(result.effects.begin(), result.effects.end(),
                                               [&](const TracedEffect& traced) {
                                                 return has_in_class(traced, found[k].effect) ||
                                                        has_in_class(found[k], traced.effect);
                                               });
      });
  nested.before = mean_over(before);
  nested.after = mean_over(after);
  nested.gain = mean_over(gain);
  return nested;
}

}  // namespace armtrue
