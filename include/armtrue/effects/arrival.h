#pragma once

#include <cmath>

#include "armtrue/effects/context.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {

/// Follows the encoder values from one visit to the next. Gives for each joint the direction of its
/// last motion and its travel since it last reversed. Assumes that every joint moves in one
/// direction between two visits.
class Arrival {
 public:
  explicit Arrival(const JointVector& start)
      : moved_last_(start), stroke_(JointVector::Zero(start.size())) {}

  /// Goes to the next visit.
  void go_to(const JointVector& q) {
    for (int j = 0; j < q.size(); ++j) {
      const double motion = q[j] - moved_last_[j];
      if (std::abs(motion) <= kMinMotion) continue;
      const bool reverses = motion * stroke_[j] < 0;
      stroke_[j] = reverses ? motion : stroke_[j] + motion;
      direction_[j] = motion > 0 ? 1 : -1;
      moved_last_[j] = q[j];
    }
  }

  /// Sign of the last motion of each joint; 0: it has not moved yet.
  const Direction& direction() const { return direction_; }
  /// Travel of each joint since its last reversal, with the sign of its motion [rad or m].
  const JointVector& stroke() const { return stroke_; }

 private:
  static constexpr double kMinMotion =
      1e-4 * kDegree;  // larger than the rounding of a file [rad or m]

  JointVector moved_last_;  // not updated by a small motion: small motions of a slow joint add up
  Direction direction_{};
  JointVector stroke_;
};

}  // namespace armtrue
