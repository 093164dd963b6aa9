#pragma once

#include <optional>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Median distance between the points of two robots with the same joints over the travel of
/// `robot`, with its base and tool fitted, effects left out [m]. Above kImplausibleMiss they are
/// two arms, or one of them has a wrong sign or zero. Zero if one has a positioner, which may stand
/// anywhere.
double distance_between_arms(const Robot& robot, const Robot& other);

/// Median distance of an arm, with base and tool placed and effects left out, from measured points
/// [m]. Nothing without points.
std::optional<double> placed_miss(const Robot& arm, const Campaign& campaign);

/// Whether placed_miss() is above 3 mm, so that the points may be those of another arm.
bool may_be_another_arm(const Robot& robot, const Campaign& campaign);

/// An arm that fits readings.
struct FittingArm {
  int index = -1;   ///< among those that were tried; -1: none fits
  double miss = 0;  ///< placed_miss()
};

/// The one of `arms` with the joints of `robot` that points fit best, if it misses them by less
/// than kImplausibleMiss and by less than a quarter of what `robot` does. None without points.
FittingArm arm_that_fits(const std::vector<Robot>& arms, const Robot& robot,
                         const Campaign& campaign);

}  // namespace armtrue
