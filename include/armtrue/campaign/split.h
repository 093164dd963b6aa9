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

/// Splits by whole poses: shuffles the poses and holds out the first `share` of them. No session
/// loses more than a third of its poses, or `share` if that is more.
Split split_by_pose(const Campaign& campaign, double share, std::uint64_t seed);

/// Holds out the `share` of the poses that lie farthest along one direction. The held-out errors
/// then show how well a result holds in a region that was not measured. The points are computed
/// with `robot`. The six directions are the principal axes of all points, longest first, each to
/// both sides: seed 1 takes the first, and seed 7 the first again.
Split split_by_region(const Robot& robot, const Campaign& campaign, double share,
                      std::uint64_t seed);

}  // namespace armtrue
