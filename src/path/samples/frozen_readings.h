#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace armtrue {

/// The standard deviation per axis of what an instrument rounds away: coordinates that change at
/// all change by no less than it rounds to.
double rounding(const Eigen::Matrix3Xd& readings);

/// How far the tool gets at most from one sample to another [m].
using Travel = std::function<double(Eigen::Index from, Eigen::Index to)>;

/// Whether the tool had left at a sample if it got so far [m] until another.
using HasLeft = std::function<bool(Eigen::Index sample, Eigen::Index next, double jump)>;

/// All samples but the frozen ones: an instrument that hangs repeats its last reading while the
/// tool goes on. The reading that ends the hold is further away than the tool gets by itself in
/// that time, but not than since the reading that is repeated. A tool that stood goes on slowly,
/// and a coarse instrument by the step that it rounds to.
std::vector<Eigen::Index> not_frozen(const Eigen::Matrix3Xd& readings, const Travel& travel,
                                     const HasLeft& has_left);

}  // namespace armtrue
