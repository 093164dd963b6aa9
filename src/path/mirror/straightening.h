#pragma once

#include <vector>

#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/mirror/path_deviation.h"

namespace armtrue {

/// Chooses the correction points of the trend, whose standard error per component is `uncertainty`;
/// with CorrectionPoints::turning makes the trend a polygon over them. A point is chosen if its
/// effect on the trend is significant against the noise (5 %). Returns the points, as samples.
std::vector<Eigen::Index> straighten(PathDeviation& deviation, CorrectionPoints how,
                                     double uncertainty);

}  // namespace armtrue
