#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/path/mirror/force_law.h"
#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// One HTML page of what mirror_correct() found, complete in itself: the numbers, the deviation of
/// each axis against time, programmed, measured and corrected path, the deviation along the path
/// before and expected after, the trend with the correction points, and with forces the deviation
/// against them (seed paper, figures 5, 7, 8, 10 and 11). `passes` names the measured passes; long
/// records are thinned, their extremes kept. Plots come from gnuplot; throws std::runtime_error if
/// it cannot be run.
std::string mirror_report(const Path& programmed, const MirrorResult& result,
                          const MirrorOptions& options, const std::optional<ForceLaw>& force,
                          const std::vector<std::string>& passes, const std::string& title);

}  // namespace armtrue
