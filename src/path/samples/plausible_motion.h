#pragma once

#include <Eigen/Core>

namespace armtrue {

// Bounds of the motion of a tool as an instrument sees it; samples beyond them are bad.

/// Largest number of consecutive samples that depart together.
inline constexpr Eigen::Index kMaxRun = 3;
/// Largest deviation of a tool from its program [m].
inline constexpr double kMaxDeviation = 10e-3;
/// Largest sudden movement of a loose or sticking tool [m].
inline constexpr double kFreePlay = 0.4e-3;
/// Chance that any sample of a clean record is called bad.
inline constexpr double kChance = 1e-3;
/// Share of bad samples above which the neighbours of a sample cannot be relied on.
inline constexpr double kMaxBadShare = 0.1;

}  // namespace armtrue
