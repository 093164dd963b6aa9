#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/gross_poses.h"
#include "report/page.h"

namespace armtrue {

/// Poses and lines of the file that the fit did not use, and why; empty if it used all. `key`: the
/// path of `gross_poses` and `excluded_rows` in the product.
void add_readings_left_out(Page& page, const std::vector<GrossPose>& gross,
                           const std::vector<int>& lines, const std::string& key);

}  // namespace armtrue
