#pragma once

#include <vector>

#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

/// What the cameras see there of the boards: of each board at most so many corners that they span
/// it, of which only the derivatives count. Throws std::invalid_argument as bind_touches() does.
Campaign image_readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses);

}  // namespace armtrue
