#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

namespace armtrue {

/// Greatest number of samples on either side of a run that predict it.
inline constexpr size_t kMaxSide = 6;
/// Number of samples on either side that predict the motion of a program: with more, every start
/// and stop would be a departure.
inline constexpr size_t kSideOfMotion = 3;

/// A sample minus its prediction from other samples.
struct NeighbourDifference {
  Eigen::Vector3d vector;
  double deviation;  ///< standard deviation of a component by chance, over that of one sample
  double length() const { return vector.norm(); }
};

/// Difference of a sample from the straight line fitted to the others (at least 2).
NeighbourDifference difference_from_line(double time, const Eigen::Vector3d& sample,
                                         std::span<const double> times,
                                         std::span<const Eigen::Vector3d> others);

/// A short run of samples with its neighbours. `before` and `after` hold times, `before_at` and
/// `after_at` positions, the nearest first.
struct Neighbours {
  size_t count;  ///< known on either side, at least 2
  std::array<double, kMaxSide> before, after;
  std::array<Eigen::Vector3d, kMaxSide> before_at, after_at;
  std::array<double, 2> ends;  ///< times of the first and the last sample of the run
  std::array<Eigen::Vector3d, 2> ends_at;

  /// Difference of an end (0, 1) of the run from the cubic through the two nearest samples of
  /// either side: zero for evenly accelerated motion.
  NeighbourDifference from_both_sides(size_t end) const;
  /// Differences of an end from the straight lines fitted to the samples before and after.
  std::array<NeighbourDifference, 2> from_each_side(size_t end) const;
};

}  // namespace armtrue
