#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/path/accuracy.h"
#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// A mirror correction and what its passes show beside it.
struct MirrorFindings {
  MirrorResult result;
  MirrorOptions options;
  std::vector<std::string> files;       ///< the measured passes
  std::vector<std::vector<int>> lines;  ///< of the files, for each sample
  PassAccuracy accuracy;                ///< of these passes, noise of the instrument included
  std::optional<PassAccuracy> before;   ///< of earlier passes, to compare with
  std::optional<ForceLaw> force;
  std::optional<ForceLine> robot;  ///< measured deviation on that predicted from the force
  double goal = kFormGoal;         ///< largest RMS form error that is wanted [m]

  /// RMS of the deviations of some passes without the noise of the instrument, which is that of
  /// these passes [m]:
  ///     sqrt(max(0, rms^2 - 2 n noise^2)),
  /// noise^2 the variance per axis of a sample of the mean of n passes, two axes across the path.
  double form_rms(const PassAccuracy& of) const;
};

/// Fills in accuracy, before, force and robot from `result` and `options`. `passes` are the passes
/// of the result, bad samples included; `earlier` are passes before the correction, bad samples
/// left out. Throws UnreachableSample if the robot cannot take a sample of the program.
void describe_passes(MirrorFindings& findings, const Path& programmed,
                     const std::vector<Path>& passes, const std::vector<Path>& earlier,
                     const std::optional<Robot>& robot);

}  // namespace armtrue
