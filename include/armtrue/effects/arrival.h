#pragma once

#include <cmath>

#include "armtrue/effects/context.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {

/// Follows the encoder angles from one visit to the next: which way each joint moved last.
class Arrival {
 public:
  explicit Arrival(const JointVector& start) : moved_last_(start) {}

  /// Sign of the last motion of each joint at the next visit; 0: it has not moved yet.
  const Direction& at(const JointVector& q) {
    for (int j = 0; j < kJoints; ++j) {
      const double motion = q[j] - moved_last_[j];
      if (std::abs(motion) <= kMinMotion) continue;
      direction_[j] = motion > 0 ? 1 : -1;
      moved_last_[j] = q[j];
    }
    return direction_;
  }

 private:
  static constexpr double kMinMotion = 1e-4 * kDegree;  // no rounding of a file is a motion

  JointVector moved_last_;  // small motions add up, so that a slow joint is seen to move too
  Direction direction_{};
};

}  // namespace armtrue
