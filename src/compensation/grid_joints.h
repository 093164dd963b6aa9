#pragma once

#include <optional>
#include <vector>

#include "armtrue/compensation/error_map.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Joint angles of the arm at the points of a grid, in the posture that is most like `start`; see
/// NearPosture. Nothing for points that the arm reaches neither from a neighbour nor from `start`.
std::vector<std::optional<JointVector>> grid_joints(const ProgramArm& arm, const Context& context,
                                                    const Grid& grid, const Pose& base,
                                                    const JointVector& start);

}  // namespace armtrue
