#pragma once

#include <vector>

#include "armtrue/compensation/error_map.h"
#include "report/svg.h"

namespace armtrue {

/// The pictures of a map: of a grid before and after, of a program from three sides and along its
/// rows.
std::vector<Drawing> error_map_pictures(const ErrorMap& map);

}  // namespace armtrue
