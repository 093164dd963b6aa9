#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

/// Where a beam ends whose reading [m] is exact, in the measured frame [m].
Eigen::Vector3d end_of_beam(const Contact& beam, double reading);

/// The robot with those beams placed that are not `known`, one flag for each contact, where the
/// readings of its poses, without effects, show them; the flags of these beams are set. With F_i
/// the pose of the measured frame, o the origin of a beam, v its direction and l_i its readings,
///     n . F_i (o + l_i v) = h   for each plane, |v| = |n| = 1,
/// is bilinear in beam and planes: Levenberg's method from directions all around; planes that are
/// known are held. Throws std::invalid_argument if a beam has fewer readings than unknowns.
Robot with_beams_placed(Robot robot, const Campaign& campaign, std::vector<bool>& known);

}  // namespace armtrue
