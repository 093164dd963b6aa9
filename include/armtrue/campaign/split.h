#pragma once

#include <cstdint>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Rows of a campaign for the fit, and rows that take no part in it. The replicates of a pose stay
/// together.
struct Split {
  std::vector<int> training, held_out;  ///< rows
};

/// Splits by whole poses: every pose of the shuffled list up to `share` is held out.
Split split_by_pose(const Campaign& campaign, double share, std::uint64_t seed);

/// Holds out the `share` of the poses that lie farthest along one direction, so that the held-out
/// errors show how a result carries over to a region that was not measured. The points are those of
/// `robot`; the directions are the principal ones of all points, the longest first, each to both
/// sides: seed 1 takes the first, seed 7 again.
Split split_by_region(const Robot& robot, const Campaign& campaign, double share,
                      std::uint64_t seed);

}  // namespace armtrue
