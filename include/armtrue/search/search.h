#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "armtrue/effects/effect.h"

namespace armtrue {

/// Options of trace() and of its search.
struct TraceOptions {
  std::uint64_t seed = 1;
  int flips = 199;  ///< sign-flipped residuals for each family-wise p-value
  /// Significance level for adding an effect: `significance` where the p of the lack of fit in
  /// position is at most 0.001, `significance_without_lack_of_fit` where it is 1 or no noise is
  /// known, log-interpolated between. If a p is near the lower level, ten times as many flips are
  /// drawn.
  double significance = 0.05, significance_without_lack_of_fit = 0.005;
  int max_effects = 16;
  int bootstrap = 1000;  ///< draws of the poses for each interval
  /// Effects that the search begins with, for example those of an earlier campaign. They must be
  /// candidates of the search, which may drop or exchange them like those that it adds.
  std::vector<Effect> start;
  bool beyond_catalogue = true;                      ///< search parameter x driver x basis as well
  /// Whether lasting errors of the instrument may be found (see is_lasting_of_instrument). They are
  /// rivals of found effects in any case.
  bool instrument_may_err = true;
  std::function<void(const std::string&)> progress;  ///< receives the name of each step
};

/// A candidate of the last scan.
struct RankedCandidate {
  Effect effect;
  std::string separated_by;
  int degrees_of_freedom = 0;    ///< independent columns left after projection
  double unexplained_share = 0;  ///< largest share of a column that no known parameter can imitate
  double score = 0;              ///< fall of EBIC
};

/// The last scan, repeated on residuals whose signs are flipped pose by pose: what the search would
/// find without any effect.
struct NullRun {
  int flips = 0;
  double false_add_rate = 0;  ///< share of the draws in which the search would have added an effect
  double score_95 = 0;        ///< fall of EBIC that the best candidate exceeds in 5 % of the draws
};

}  // namespace armtrue
