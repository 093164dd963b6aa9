#pragma once

namespace armtrue {

/// Of an arm [kg], in a file or an option: the strongest arms carry 2300. More is another unit.
inline constexpr double kHeaviestPayload = 2500;

}  // namespace armtrue
