#pragma once

#include <vector>

#include "armtrue/path/mirror/path_deviation.h"

namespace armtrue {

/// The sample nearest in time, at `from` or after it.
Eigen::Index nearest_sample(const Path& path, double time, Eigen::Index from);

/// What a registered pass deviates by while the program moves.
struct AcrossInMotion {
  Eigen::Matrix3Xd deviation;         ///< across the path [m]
  std::vector<Eigen::Index> nearest;  ///< the sample of the program nearest in time
};

/// `tangent`: of the program, side_tangents().
AcrossInMotion across_in_motion(const Path& programmed, const Eigen::Matrix3Xd& tangent,
                                const Path& pass);

/// Registers the records, each by itself but for a fitted frame, which they share, and removes
/// their bad samples: first those that could mislead the clock, then those that only the deviations
/// show. Throws TooManyBadSamples, and UnusablePass where fit_clock() throws.
std::vector<Pass> register_passes(const Path& programmed, std::vector<Path>& records,
                                  const ClockOptions& options);

/// Mean deviation of registered passes on the grid of all of them.
PathDeviation mean_deviation(const Path& programmed, const std::vector<Path>& measured,
                             const std::vector<Pass>& passes);
/// The same from the path that the controller ran in place of the program [m]: what the arm itself
/// deviates by, whatever correction it ran. The trend stays.
PathDeviation from_executed(PathDeviation deviation, const Path& programmed,
                            const Eigen::Matrix3Xd& executed);
/// The deviation of one of the passes on the same grid.
PathDeviation deviation_of_pass(const Path& programmed, const std::vector<Path>& measured,
                                const std::vector<Pass>& passes, size_t which);

}  // namespace armtrue
