#pragma once

#include <vector>

#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// The sample nearest in time, searched onwards of `from`.
Eigen::Index nearest_sample(const Path& path, double time, Eigen::Index from);

/// Registers the records, each by itself, and takes their bad samples out of them: first those that
/// could mislead the clock, then those that only its deviations show.
std::vector<Pass> register_passes(const Path& programmed, std::vector<Path>& records,
                                  const ClockOptions& options);

/// Mean deviation of registered passes, and the deviation of one of them on the same grid.
PathDeviation mean_deviation(const Path& programmed, const std::vector<Path>& measured,
                             const std::vector<Pass>& passes);
PathDeviation deviation_of_pass(const Path& programmed, const std::vector<Path>& measured,
                                const std::vector<Pass>& passes, size_t which);

}  // namespace armtrue
