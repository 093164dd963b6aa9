#pragma once

#include <vector>

namespace armtrue {

/// The documents of config/presets, built in.
extern const std::vector<const char*> kShippedPresets;

}  // namespace armtrue
