#pragma once

#include <vector>

#include "armtrue/search/search.h"
#include "search/effect_model.h"

namespace armtrue {

/// The result of a search, without the evidence for each effect, which with_evidence() adds.
struct SearchResult {
  EffectModel model;
  std::vector<CalibrationResult> stages;  ///< geometry alone, then with each effect as it was added
  std::vector<RankedCandidate> ranking;   ///< of the last scan, best first
  std::vector<RankedCandidate> not_separable;  ///< of the catalogue; see TraceResult
  double best_score = 0;                       ///< of the last scan
  double remaining_p = 1;        ///< family-wise p of the best candidate that was not added
  bool pattern_remains = false;  ///< see TraceResult
  NullRun null_run;
};

/// Searches for the effects that the model lacks. Forward steps add one candidate each; after each,
/// the search revises the model by the one exchange or drop that lowers EBIC most; a spline
/// replaces several effects of one parameter and driver if EBIC prefers it. It ends when nothing
/// more lowers EBIC. Keeps references to `campaign` and `options` in the model. Throws
/// std::invalid_argument as EffectModel does, and if `options.start` names no candidate.
SearchResult search_effects(const Robot& robot, const Campaign& campaign,
                            const Catalogue& catalogue, const TraceOptions& options);

}  // namespace armtrue
