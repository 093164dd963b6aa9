#pragma once

#include "armtrue/effects/robot.h"

namespace armtrue {

/// How far two robots with the same joints are from being models of one arm [m]: the median
/// distance of their points over the travel of `robot`, with its base and tool fitted, effects left
/// out. Above kImplausibleMiss they are two arms, or one of them has a wrong sign or zero. Zero if
/// one has a positioner, which may stand anywhere.
double distance_between_arms(const Robot& robot, const Robot& other);

}  // namespace armtrue
