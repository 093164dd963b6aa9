#pragma once

#include <string>

#include "armtrue/compensation/error_map.h"

namespace armtrue {

enum class PictureFormat { svg, png };

/// The picture of a map. Of a grid: up to three slices across the side with the fewest points, the
/// error before (above, with its arrows) and what would be left (below). Of a program: its points
/// from above and from the side, and the errors along its rows. Throws std::runtime_error without
/// gnuplot.
std::string error_map_plot(const ErrorMap& map, PictureFormat format);

}  // namespace armtrue
