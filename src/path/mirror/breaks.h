#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// Times of a program at which its deviation may jump: the tool starts, stops or turns a corner, or
/// a joint reverses (where the joint angles are known) [s].
std::vector<double> program_breaks(const Path& programmed);

/// Splits samples where they jump: by more than chance at `likely` places, by much more elsewhere.
/// `noise` is the standard deviation of a sample per axis, `window` the number of samples on either
/// side that are compared. Returns the first sample of every piece but the first, in order.
std::vector<Eigen::Index> find_jumps(const Eigen::Matrix3Xd& samples, double noise,
                                     Eigen::Index window, const std::vector<Eigen::Index>& likely);

}  // namespace armtrue
