#pragma once

#include <optional>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

/// Points that a run measured, and the spread of its residuals.
struct MeasuredRun {
  const Campaign* campaign = nullptr;
  ReadingSigma spread;
};

/// The result of readings_difference().
struct ReadingsDifference {
  double p_value = 1;  ///< that one arm explains the readings of both runs
  double p_value_beside_scale =
      1;  ///< the same if the later instrument may have a scale of its own
  /// The F of the test over the one below which a change is not seen (kChangeSignificance). F grows
  /// as the square of a change.
  double times_seen = 0;

  bool moved() const;
};

/// Tests by the readings of two runs whether one arm explains both (Chow, "Tests of equality
/// between sets of coefficients in two linear regressions", 1960): links and effects common to both
/// runs against links and effects of each run's own; base and tool are each run's own in any case.
/// With S the sums of squares, q the unknowns that the common fit lacks and f the numbers less the
/// unknowns of the fits of their own,
///     F = (S_common - S_own) / q / (S_own / f).
/// What the models lack stands in S_own, so that it is no change; a pose counts once, by the mean
/// of its readings, because they share it. The numbers of each run count in units of their scatter
/// about its own fit. What models lack is not normal: a p below
/// kChangeSignificance must stand against the F of 199 exchanges of poses between the runs, too.
/// Linear about `before`, the model of the first run; `after`
/// is that of the second. Nothing where a run measured no points, where a model has sessions, or
/// where the readings of a run determine no more than its own unknowns.
std::optional<ReadingsDifference> readings_difference(const Robot& before, const MeasuredRun& first,
                                                      const Robot& after,
                                                      const MeasuredRun& second);

}  // namespace armtrue
