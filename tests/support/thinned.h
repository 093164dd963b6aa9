#pragma once

#include <cstdlib>

namespace armtrue {

/// A test that counts how often something happens takes one campaign in `n`, and all of them in the
/// long run, for which ctest sets ARMTRUE_WHOLE (see WHOLE in tests/CMakeLists.txt). Returns n, or
/// 1 in the long run. Shares scatter sqrt(n) times as much as in the long run.
inline int thinned(int n) { return std::getenv("ARMTRUE_WHOLE") ? 1 : n; }

}  // namespace armtrue
