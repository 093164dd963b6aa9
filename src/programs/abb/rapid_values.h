#pragma once

#include <optional>

#include "armtrue/programs/robot_program.h"
#include "programs/statement.h"

namespace armtrue {

/// Of the confdata of a point: cf1, cf4, cf6 are quadrants. cfx, which not every arm uses: 4: the
/// wrist is behind axis 1; 2: behind the lower arm; 1: axis 5 is below zero.
Configuration rapid_configuration(const ProgramPoint& point);

/// Whether a list is four numbers of norm 1, but for rounding.
bool is_rapid_quaternion(const ListItem& list);

/// Whether the value of an axis is not 9E9, which says that the arm has no such axis.
bool is_rapid_axis(double value);

/// Of [[x, y, z], [q1, q2, q3, q4]]; nothing if it is none.
std::optional<Pose> rapid_pose(const ListItem& list);

}  // namespace armtrue
