#pragma once

#include "armtrue/path/path.h"

namespace armtrue {

/// Throws std::invalid_argument, naming the unit, if a column is in another unit than its name
/// says: the extents of the paths, or the speeds of the tool in them, differ by the factor between
/// two units. Throws it too if the paths look exchanged: the program has noise of 5 um or more, and
/// the record a tenth of it or less (sixth differences of regular samples).
void check_units(const Path& programmed, const Path& measured);

}  // namespace armtrue
