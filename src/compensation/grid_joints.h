#pragma once

#include <optional>
#include <vector>

#include "armtrue/compensation/error_map.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Joint angles of the arm at the points of a grid: shoulder and elbow as at `start`, of the two
/// postures of the wrist the one whose axis 4 is nearer to it, and the nearest whole turns that the
/// travel allows. Nothing where the arm comes neither from a neighbour nor from `start`.
std::vector<std::optional<JointVector>> grid_joints(const ProgramArm& arm, const Context& context,
                                                    const Grid& grid, const Pose& base,
                                                    const JointVector& start);

}  // namespace armtrue
