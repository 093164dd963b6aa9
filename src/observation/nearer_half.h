#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "armtrue/statistics/summary.h"

namespace armtrue {

/// Fits to all of `count`, then twice to the half of them with the smaller errors, but to `fewest`
/// at least, what a fit needs: fit(indices) and miss(found, index).
template <typename Fit, typename Miss>
auto fit_nearer_half(std::ptrdiff_t count, std::ptrdiff_t fewest, const Fit& fit,
                     const Miss& miss) {
  std::vector<int> chosen(count);
  std::iota(chosen.begin(), chosen.end(), 0);
  auto found = fit(chosen);
  for (int round = 0; round < 2; ++round) {
    std::vector<double> misses;
    for (int k = 0; k < count; ++k) misses.push_back(miss(found, k));
    std::vector<double> ascending = misses;
    std::ranges::sort(ascending);
    const double limit = std::max(median(misses), ascending[std::min(fewest, count) - 1]);
    chosen.clear();
    for (int k = 0; k < count; ++k)
      if (misses[k] <= limit) chosen.push_back(k);
    found = fit(chosen);
  }
  return found;
}

}  // namespace armtrue
