#include "path/samples/neighbours.h"

#include <cmath>

namespace armtrue {
namespace {

using Eigen::Vector3d;

// Difference of a sample from the cubic through four others (Lagrange).
NeighbourDifference difference_from_cubic(double time, const Vector3d& sample,
                                          const std::array<double, 4>& times,
                                          const std::array<Vector3d, 4>& others) {
  Vector3d off = sample;
  double variance = 1;
  for (size_t j = 0; j < 4; ++j) {
    double weight = 1;
    for (size_t k = 0; k < 4; ++k)
      if (k != j) weight *= (time - times[k]) / (times[j] - times[k]);
    off -= weight * others[j];
    variance += weight * weight;
  }
  return {off, std::sqrt(variance)};
}

}  // namespace

NeighbourDifference difference_from_line(double time, const Vector3d& sample,
                                         std::span<const double> times,
                                         std::span<const Vector3d> others) {
  const auto n = static_cast<double>(times.size());
  double mean = 0, square = 0;
  for (const double other : times) mean += other / n;
  for (const double other : times) square += (other - mean) * (other - mean);
  Vector3d off = sample;
  for (size_t j = 0; j < times.size(); ++j)
    off -= (1 / n + (time - mean) * (times[j] - mean) / square) * others[j];
  return {off, std::sqrt(1 + 1 / n + (time - mean) * (time - mean) / square)};
}

NeighbourDifference Neighbours::from_both_sides(size_t end) const {
  return difference_from_cubic(ends[end], ends_at[end], {before[1], before[0], after[0], after[1]},
                               {before_at[1], before_at[0], after_at[0], after_at[1]});
}

std::array<NeighbourDifference, 2> Neighbours::from_each_side(size_t end) const {
  const auto known = [&](const auto& side) { return std::span(side).first(count); };
  return {difference_from_line(ends[end], ends_at[end], known(before), known(before_at)),
          difference_from_line(ends[end], ends_at[end], known(after), known(after_at))};
}

}  // namespace armtrue
