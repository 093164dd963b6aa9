#pragma once

#include <cstdint>
#include <vector>

#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

/// Random configurations under the limits of the cloud that show whole boards to the cameras, see
/// random_viewpoints(). May be fewer than `count`.
std::vector<PlannedPose> random_image_poses(const PoseCloud& cloud, int count, std::uint64_t seed);

/// What the cameras see there of the boards: of each board at most so many corners that they span
/// it, of which only the derivatives count. Throws std::invalid_argument as bind_touches() does.
Campaign image_readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses);

}  // namespace armtrue
