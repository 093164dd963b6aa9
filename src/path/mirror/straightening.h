#pragma once

#include <vector>

#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// Makes the trend, known to `uncertainty` per component, straight between its correction points;
/// returns these. A point has to make a difference that noise would not make: 5 % of chance.
std::vector<Eigen::Index> straighten(PathDeviation& deviation, CorrectionPoints how,
                                     double uncertainty);

}  // namespace armtrue
