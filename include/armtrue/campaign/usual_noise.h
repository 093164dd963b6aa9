#pragma once

namespace armtrue {

/// Noise of usual instruments, per axis, where nothing states it.
inline constexpr double kUsualPositionNoise = 1e-4;     // m
inline constexpr double kUsualOrientationNoise = 1e-4;  // rad
inline constexpr double kUsualPixelNoise = 0.2;         // px

/// The first of these that is above zero.
inline double stated_or_usual(double asked, double stated, double usual) {
  if (asked > 0) return asked;
  return stated > 0 ? stated : usual;
}

}  // namespace armtrue
