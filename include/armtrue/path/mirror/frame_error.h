#pragma once

#include <cmath>

namespace armtrue {

/// Uncertainty of the deviation across a path by a fitted frame: the frame absorbs a part of the
/// deviation, and no record shows how much.
struct FrameError {
  double mean_square = 0;     ///< of the deviation that it hides or makes [m^2]
  double form_deviation = 0;  ///< standard deviation of the mean square of the deviation [m^2]

  double rms() const { return std::sqrt(mean_square); }  ///< [m]
};

}  // namespace armtrue
