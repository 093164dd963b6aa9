#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "armtrue/programs/dialect.h"

// The numbers of a point as they are written, in the unit of the dialect or in counts, and as text.

namespace armtrue {

/// As they are written.
std::vector<double> values_of(const std::vector<ProgramNumber>& numbers);
/// The encoder angles [rad] of a point of joint angles.
JointVector joints_of_point(const Dialect& dialect, const ProgramPoint& point);
/// The numbers of a point that has these encoder angles.
std::vector<double> numbers_of_joints(const Dialect& dialect, const ProgramPoint& point,
                                      const JointVector& q);
/// Decimals that a changed number has at least.
int decimals_of(const Dialect& dialect, const ProgramPoint& point, size_t component);
/// Whether a joint is programmed in a range [rad], up to the rounding of a written pose, and
/// commanded farther outside of it.
bool leaves(double low, double high, int joint, const ProgramCommand& command);

/// Decimal places of a number as it is written: digits behind the point less the exponent, at most
/// 9, as a double of some metres has no more.
int written_decimals(std::string_view number);
/// With `decimals` decimals, or more if `at_least` is more, but without zeros behind `at_least`.
std::string rounded_text(double value, int at_least, int decimals);

/// Angles a, b, c [rad] of R = Rz(a) Ry(b) Rx(c), those next to `near`: (a, b, c) and (a + pi, pi -
/// b, c + pi) are the same rotation, and at b = +-pi/2 only a -+ c is defined.
Eigen::Vector3d abc_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near);
/// The rotation vector [rad] of a rotation, the one next to `near`: v + 2 pi k v / |v| are one
/// rotation.
Eigen::Vector3d rotation_vector_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near);

}  // namespace armtrue
