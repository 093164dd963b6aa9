#pragma once

namespace armtrue {

/// Largest payload that a file or an option may state [kg]. The strongest arms carry 2300; more is
/// another unit.
inline constexpr double kHeaviestPayload = 2500;

}  // namespace armtrue
