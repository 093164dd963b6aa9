#include "path/samples/frozen_readings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "armtrue/path/path.h"
#include "armtrue/statistics/summary.h"
#include "path/samples/plausible_motion.h"
#include "statistics/white_noise.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Consecutive samples with the same reading.
struct Hold {
  Index first, last;
};

// Holds more than twice as long as the median: an instrument that is asked more often than it
// measures repeats every reading.
std::vector<Hold> long_holds(const Eigen::Matrix3Xd& readings) {
  std::vector<Hold> holds;
  std::vector<double> lengths;
  int first = 0;
  for (int i = 1; i <= readings.cols(); ++i) {
    if (i < readings.cols() && (readings.col(i) - readings.col(first)).norm() <= kStandstill)
      continue;
    lengths.push_back(i - first);
    holds.push_back({first, i - 1});
    first = i;
  }
  if (lengths.empty()) return holds;
  const double usual = median(std::move(lengths));
  std::erase_if(holds, [&](const Hold& hold) {
    return static_cast<double>(hold.last - hold.first + 1) <= 2 * usual;
  });
  return holds;
}

}  // namespace

double rounding(const Eigen::Matrix3Xd& readings) {
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 1; i < readings.cols(); ++i)
    for (const double step : Vector3d(readings.col(i) - readings.col(i - 1)))
      if (std::abs(step) > kStandstill) least = std::min(least, std::abs(step));
  return std::isfinite(least) ? least / std::sqrt(12) : 0;
}

std::vector<Index> not_frozen(const Eigen::Matrix3Xd& readings, const Travel& travel,
                              const HasLeft& has_left) {
  const Index count = readings.cols();
  std::vector<bool> frozen(count, false);
  const std::vector<Hold> holds = long_holds(readings);
  const double noise = holds.empty() ? 0 : std::max(rounding(readings), white_noise(readings));
  const double chance =
      normal_length_exceeded(kChance / static_cast<double>(count)) * std::numbers::sqrt2 * noise;
  for (const auto& [first, last] : holds) {
    const Index next = last + 1;
    if (next == count) continue;  // at the end the tool may stand
    const double jump = (readings.col(next) - readings.col(last)).norm();
    if (jump <= travel(last, next) + std::max(kFreePlay, chance) ||
        jump > travel(first, next) + kMaxDeviation)
      continue;
    for (Index k = first + 1; k <= last; ++k) frozen[k] = has_left(k, next, jump);
  }
  std::vector<Index> rest;
  for (Index k = 0; k < count; ++k)
    if (!frozen[k]) rest.push_back(k);
  return rest;
}

}  // namespace armtrue
