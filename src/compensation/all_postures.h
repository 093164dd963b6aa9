#pragma once

#include <optional>
#include <vector>

#include "compensation/program_arm.h"

namespace armtrue {

/// All postures of an arm of six axes at a pose, in a fixed order and to whole turns of the joints:
/// up to eight, by two sides each of shoulder, elbow and wrist. They follow in closed form where
/// axis 1 is across axis 2, axis 3 along it and axes 4 to 6 meet in a point across each other, and
/// are then refined on the arm as it is. Nothing if the arm is not built so, to 10 mrad and 5 mm,
/// or if a pose is so near the limit of a branch that it is not clear whether the branch reaches
/// it. `wanted`: R_0 from TCP. `context`: its q holds the external axes.
std::optional<std::vector<JointVector>> all_postures(const ProgramArm& arm, Context context,
                                                     const Pose& wanted);

}  // namespace armtrue
