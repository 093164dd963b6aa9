#pragma once

#include <string>

#include "armtrue/path/mirror/findings.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// The page of a mirror correction: the numbers, the deviation of each axis against time, the
/// programmed, measured and corrected path, the deviation along the path before and expected after,
/// the trend with the correction points, and with forces the deviation against them (seed paper,
/// figures 5, 7, 8, 10 and 11). Long records are thinned: each interval keeps its smallest and its
/// largest value. `program`: name of the programmed path. The keys are those of armtrue-mirror/1.
Report mirror_page(const Path& programmed, const MirrorFindings& findings,
                   const std::string& program, const PageHead& head);

}  // namespace armtrue
