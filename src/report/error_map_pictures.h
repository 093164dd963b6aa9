#pragma once

#include <vector>

#include "armtrue/compensation/error_map.h"
#include "report/svg.h"

namespace armtrue {

/// The pictures of a map: for a grid, before and after; for a program, three views and the errors
/// along its rows.
std::vector<Drawing> error_map_pictures(const ErrorMap& map);

}  // namespace armtrue
