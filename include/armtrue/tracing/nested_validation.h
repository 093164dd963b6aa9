#pragma once

#include <vector>

#include "armtrue/search/trace.h"

namespace armtrue {

/// Mean over the outer folds and its standard error, from the scatter of the folds. These share
/// most of their training poses, so the true error is somewhat larger (Bengio, Grandvalet 2004).
struct FoldMean {
  double mean = 0, error = 0;
};

/// Accuracy of the whole procedure, search included, on poses that it has not seen.
struct NestedValidation {
  int folds = 0;
  /// Position error with geometry alone and with the effects, and its fall [m].
  FoldMean before, after, gain;
  /// For each effect of `found`: number of folds that found it, or one indistinguishable from it,
  /// again.
  std::vector<int> found_again;
};

/// Repeats the complete search in each of `folds` outer folds of the poses and evaluates it on the
/// poses left out. Every pose, with all its readings, is left out once; every session is spread
/// over the folds. Folds are computed in parallel; the result does not depend on the number of
/// threads. Throws std::invalid_argument if there are fewer than two folds or fewer poses than
/// folds, and as close_loop() does if a fold leaves too few poses for the fit.
NestedValidation nested_validation(const Robot& robot, const Campaign& campaign,
                                   const Catalogue& catalogue, int folds,
                                   const std::vector<TracedEffect>& found,
                                   const TraceOptions& options = {});

}  // namespace armtrue
