#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace armtrue {

/// Fisher and Yates's shuffle with the engine's own numbers: std::shuffle differs between
/// libraries.
inline void shuffle(std::vector<int>& items, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random() % i]);
}

}  // namespace armtrue
