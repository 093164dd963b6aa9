#pragma once

#include <optional>

#include "armtrue/kinematics/pose.h"
#include "armtrue/programs/division.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// The way of the TCP in a straight or circular move, at constant speed from t = 0 to 1.
struct Way {
  Pose start, end;
  std::optional<Arc> arc;  ///< none: a line
  ArcTurning turning = ArcTurning::in_frame;

  /// On a line the rotation is R_start exp(t log(R_start' R_end)). On an arc that turns with its
  /// path it is that in a frame that turns by t * angle about the normal of the arc.
  Pose at(double t) const;
  double length() const;  ///< [m]
};

}  // namespace armtrue
