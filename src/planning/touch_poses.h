#pragma once

#include <cstdint>
#include <vector>

#include "armtrue/planning/pose_cloud.h"

namespace armtrue {

/// What is touched in the given poses, or without them all contacts of the robot by all its
/// targets: poses without configurations. Throws std::invalid_argument if nothing says where a
/// contact is.
std::vector<PlannedPose> touches_to_plan(const Robot& robot, const Campaign& given);

/// Random configurations under the limits of the cloud in which the robot touches, each of
/// PoseCloud::touches in turn. The arm stands on the side of a plane on which it stood in the given
/// poses, or to which its z axis shows, and outside a sphere. May be fewer than `count`.
std::vector<PlannedPose> random_touches(const PoseCloud& cloud, int count, std::uint64_t seed);

/// Lets beams that do not state their range read from the least to the largest given reading.
void state_ranges(const Campaign& given, KinematicChain& chain);

/// What the touches or beams read there: of a point three rows; of which only the derivatives
/// count.
Campaign touch_readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses);

/// The given poses, each once, with what was touched, or what the beam read there.
std::vector<PlannedPose> given_touches(const PoseCloud& cloud);

}  // namespace armtrue
