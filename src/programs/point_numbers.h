#pragma once

#include <vector>

#include "armtrue/programs/dialect.h"

// The numbers of a point as they are written, in the unit of the dialect or in counts.

namespace armtrue {

/// The encoder angles [rad] of a point of joint angles.
JointVector joints_of_point(const Dialect& dialect, const ProgramPoint& point);
/// The numbers of a point that has these encoder angles.
std::vector<double> numbers_of_joints(const Dialect& dialect, const ProgramPoint& point,
                                      const JointVector& q);
/// Decimals that a changed number has at least.
int decimals_of(const Dialect& dialect, const ProgramPoint& point, size_t component);

}  // namespace armtrue
