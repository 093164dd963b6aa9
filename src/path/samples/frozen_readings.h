#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace armtrue {

/// Standard deviation per axis of what an instrument rounds away [m]: step / sqrt(12), with step
/// the smallest change of a coordinate between neighbours.
double rounding(const Eigen::Matrix3Xd& readings);

/// The furthest that the tool may travel from one sample to another [m].
using Travel = std::function<double(Eigen::Index from, Eigen::Index to)>;

/// Whether the tool had moved on at `sample`, given that the record jumps by `jump` [m] at `next`.
using HasLeft = std::function<bool(Eigen::Index sample, Eigen::Index next, double jump)>;

/// All samples but the frozen ones. An instrument that hangs repeats its last reading while the
/// tool goes on. The next reading then lies further off than the tool travels in one sample, but no
/// further than it travels since the first of the repeated readings. After a standstill the tool
/// goes on slowly; a coarse instrument goes on by the step to which it rounds.
std::vector<Eigen::Index> not_frozen(const Eigen::Matrix3Xd& readings, const Travel& travel,
                                     const HasLeft& has_left);

}  // namespace armtrue
