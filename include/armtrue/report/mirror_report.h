#pragma once

#include <string>

#include "armtrue/path/mirror/findings.h"

namespace armtrue {

/// One HTML page on a mirror correction, complete in itself: the numbers, the deviation of each
/// axis against time, the programmed, measured and corrected path, the deviation along the path
/// before and expected after, the trend with the correction points, and with forces the deviation
/// against them (seed paper, figures 5, 7, 8, 10 and 11). Long records are thinned; each stretch
/// keeps its smallest and its largest value. Throws std::runtime_error if gnuplot, which draws the
/// plots, cannot be run.
std::string mirror_report(const Path& programmed, const MirrorFindings& findings,
                          const std::string& title);

}  // namespace armtrue
