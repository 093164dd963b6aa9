#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/gross_poses.h"
#include "report/page.h"

namespace armtrue {

/// Which poses and lines of the file took no part, and why; nothing if all did. `key`: the path of
/// `gross_poses` and `excluded_rows` in the product.
void add_readings_left_out(Page& page, const std::vector<GrossPose>& gross,
                           const std::vector<int>& lines, const std::string& key);

}  // namespace armtrue
