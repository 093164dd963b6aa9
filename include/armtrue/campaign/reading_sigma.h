#pragma once

namespace armtrue {

/// Standard deviation of the readings about the model, per axis.
struct ReadingSigma {
  double position = 1;     ///< [m]
  double orientation = 1;  ///< [rad]
};

}  // namespace armtrue
