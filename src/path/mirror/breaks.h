#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/mirror/path_deviation.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// Times of a program at which its deviation may jump [s], in order: the tool starts, stops or
/// turns a corner, or a joint reverses (if the path has joint angles).
std::vector<double> program_breaks(const Path& programmed);

/// Splits samples where they jump by more than chance: 1 % for each of the `likely` samples, 0.1 %
/// for all others together. `noise`: standard deviation of a sample per axis; `window`: number of
/// samples on either side that are compared. Returns the first sample of every piece but the first,
/// in order.
std::vector<Eigen::Index> find_jumps(const Eigen::Matrix3Xd& samples, double noise,
                                     Eigen::Index window, const std::vector<Eigen::Index>& likely);

/// Fills `engagement` and `breaks` of a deviation whose `noise` is known. Jumps are likely at
/// program_breaks() and where the tool enters or leaves the material.
void find_breaks(const Path& programmed, PathDeviation& deviation);

}  // namespace armtrue
