#pragma once

#include "armtrue/path/path.h"

namespace armtrue {

/// Throws std::invalid_argument, naming the unit, if a column is in another unit than its name
/// says: the extents of the paths, or the speeds of the tool, differ by the factor between two
/// units. Also throws if the paths look exchanged: the program has noise of 5 um or more, and the
/// record at most a tenth of it (sixth differences of regular samples).
void check_units(const Path& programmed, const Path& measured);

}  // namespace armtrue
