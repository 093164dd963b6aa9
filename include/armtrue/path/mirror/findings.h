#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/path/accuracy.h"
#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/form_error.h"
#include "armtrue/path/mirror/mirror.h"
#include "armtrue/path/registration/force_clock.h"

namespace armtrue {

/// Accuracy of passes against their program, noise of the instrument included.
struct PassAccuracy {
  PathAccuracy path;  ///< in planes, as ISO 9283 says
  PathErrors errors;  ///< of the samples of all passes while the program moves
  Eigen::Index samples = 0;
};

/// A mirror correction and the other figures of its passes.
struct MirrorFindings {
  MirrorResult result;
  MirrorOptions options;
  std::vector<std::string> files;       ///< the measured passes
  std::vector<std::vector<int>> lines;  ///< of the files, for each sample
  /// Of each pass, if its force was recorded with a clock of its own; else empty.
  struct Force {
    std::string file;
    ForceClock clock;
  };
  std::vector<Force> forces;
  PassAccuracy accuracy;                ///< of these passes
  FormError form;                       ///< of these passes
  std::optional<PassAccuracy> before;   ///< of earlier passes, for comparison
  std::optional<FormError> form_before;
  std::optional<PathDeviation> deviation_before;  ///< mean of the earlier passes; without a trend
  /// From the path that the passes ran, if that was a correction: it takes off what the arm yields
  /// by, but not that the arm yields.
  std::optional<PathDeviation> from_executed;
  const PathDeviation& of_arm() const { return from_executed ? *from_executed : result.deviation; }
  std::optional<ForceLaw> force;   ///< of of_arm(), as `robot`
  std::optional<ForceLine> robot;  ///< measured deviation on that predicted from the force
  double goal = kFormGoal;         ///< largest allowed RMS form error [m]
  /// A joint of the robot turns back on the program.
  struct Reversal {
    double time;        ///< [s]
    std::string joint;  ///< q2
  };
  std::optional<std::vector<Reversal>> reversals;  ///< if the robot is known
};

/// The median of the largest of n lengths of the noise alone across the path, with s of one reading
/// per axis and n the samples of `accuracy` [m]:
///     s sqrt(-2 ln(1 - 2^(-1/n))).
double largest_of_noise(const MirrorFindings& findings);

/// Fills in accuracy and form, those before with their deviation, force and robot from `result` and
/// `options`. `passes` are the passes of the result, bad samples included; `earlier` are passes
/// before the correction, bad samples left out. Throws UnreachableSample if the robot cannot take a
/// sample of the program.
void describe_passes(MirrorFindings& findings, const Path& programmed,
                     const std::vector<Path>& passes, const std::vector<Path>& earlier,
                     const std::optional<Robot>& robot);

}  // namespace armtrue
