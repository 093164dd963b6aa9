#pragma once

#include "armtrue/path/path.h"

namespace armtrue {

/// Throws std::invalid_argument, naming the unit, if a column is in another unit than its name
/// says: the extents of the paths, or the speeds of the tool in them, differ by the factor between
/// two units.
void check_units(const Path& programmed, const Path& measured);

}  // namespace armtrue
