#pragma once

#include <optional>

#include "armtrue/path/path.h"

namespace armtrue {

/// Throws std::invalid_argument, naming the unit, if a column is in another unit than its name
/// says: the extents of the paths, or the speeds of the tool, differ by the factor between two
/// units. Also throws if the paths look exchanged: the program has noise of 5 um or more, and the
/// record at most a tenth of it (sixth differences of regular samples).
void check_units(const Path& programmed, const Path& measured);

/// Standard deviation of independent errors per axis [m], from sixth differences, in which a smooth
/// path leaves nothing. Empty if the samples are few or their times irregular.
std::optional<double> noise_of_samples(const Path& path);

}  // namespace armtrue
