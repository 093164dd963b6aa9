#pragma once

#include <vector>

#include "armtrue/search/trace.h"

namespace armtrue {

/// Mean over the outer folds and its standard error, from how the folds differ. They share most of
/// their training poses, so the true error is somewhat larger (Bengio, Grandvalet 2004).
struct FoldMean {
  double mean = 0, error = 0;
};

/// What the whole procedure, search and all, is worth on poses that it has not seen.
struct NestedValidation {
  int folds = 0;
  FoldMean before, after, gain;  ///< position error with geometry alone, with the effects; fall [m]
  /// Of each effect asked about: in how many folds it, or one that cannot be told from it, was
  /// found again.
  std::vector<int> found_again;
};

/// Repeats the complete search in each of `folds` outer folds of the poses and judges it on the
/// poses left out. Every pose, with all its readings, is left out once; every session is spread
/// over the folds. Folds are computed side by side, the result is the same on any number of
/// threads. Throws std::invalid_argument if there are fewer than two folds or fewer poses than
/// folds, and as close_loop() does where a fold leaves too little to learn from.
NestedValidation nested_validation(const Robot& robot, const Campaign& campaign,
                                   const Catalogue& catalogue, int folds,
                                   const std::vector<TracedEffect>& found,
                                   const TraceOptions& options = {});

}  // namespace armtrue
