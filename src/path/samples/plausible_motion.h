#pragma once

#include <Eigen/Core>

namespace armtrue {

// What a tool may do and an instrument sees of it; what goes beyond is a bad sample.

/// Consecutive samples that depart together.
inline constexpr Eigen::Index kFew = 3;
/// [m] of a tool from its program.
inline constexpr double kMaxDeviation = 10e-3;
/// [m]: a loose or sticking tool moves as suddenly.
inline constexpr double kFreePlay = 0.4e-3;
/// Of calling any sample bad in a record without.
inline constexpr double kChance = 1e-3;
/// Of a record; with more of them the neighbours of each cannot be relied on.
inline constexpr double kShareTooMany = 0.1;

}  // namespace armtrue
