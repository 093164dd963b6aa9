#pragma once

#include "armtrue/path/mirror/findings.h"
#include "report/svg.h"

namespace armtrue {

/// Deviation of each axis against the time of the program (figure 5).
Drawing deviation_picture(const MirrorFindings& findings);

/// Programmed, measured and corrected path in the plane of the two longest axes (figure 7).
Drawing path_picture(const Path& programmed, const MirrorResult& result);

/// Distance from the path along it (figure 11): measured before and after the correction that ran;
/// without passes before it, measured and less the new correction.
Drawing correction_picture(const Path& programmed, const MirrorFindings& findings);

/// Trend of each axis with the points of the correction (figure 10).
Drawing trend_picture(const Path& programmed, const MirrorResult& result);

/// Force on the tool of each axis against the time of the program (figure 6).
Drawing force_over_time(const PathDeviation& deviation);

/// Deviation against force with the fitted line, if there is one (figure 8).
Drawing force_picture(const PathDeviation& deviation, const ForceLaw& law);

}  // namespace armtrue
