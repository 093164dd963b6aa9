#pragma once

#include <vector>

#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/mirror/path_deviation.h"

namespace armtrue {

/// Chooses the correction points of the trend, whose standard error per component is `uncertainty`;
/// with CorrectionPoints::turning makes the trend a polygon over them. A point is chosen if it
/// makes a difference that noise makes with a chance of 5 % at most. Returns the points, as
/// samples.
std::vector<Eigen::Index> straighten(PathDeviation& deviation, CorrectionPoints how,
                                     double uncertainty);

}  // namespace armtrue
