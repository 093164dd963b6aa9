#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace armtrue {

/// Standard deviation per axis of the rounding of an instrument [m]: step / sqrt(12), with step the
/// smallest change of a coordinate between neighbours.
double rounding(const Eigen::Matrix3Xd& readings);

/// Largest travel of the tool from one sample to another [m].
using Travel = std::function<double(Eigen::Index from, Eigen::Index to)>;

/// Whether the tool had moved on at `sample`, given that the record jumps by `jump` [m] at `next`.
using HasLeft = std::function<bool(Eigen::Index sample, Eigen::Index next, double jump)>;

/// All samples but the frozen ones. A frozen instrument repeats its last reading while the tool
/// moves on. The next reading is then farther away than the tool travels in one sample, but no
/// farther than it travels since the first of the repeated readings. After a standstill, in
/// contrast, the tool starts slowly; a coarse instrument changes by one step of its rounding.
std::vector<Eigen::Index> not_frozen(const Eigen::Matrix3Xd& readings, const Travel& travel,
                                     const HasLeft& has_left);

}  // namespace armtrue
