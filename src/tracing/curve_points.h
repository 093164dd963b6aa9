#pragma once

#include <algorithm>

#include "armtrue/effects/shape.h"

namespace armtrue {

/// How many points show a curve of this shape: four for each piece of a spline or half a cycle.
inline int curve_points(const Shape& shape) {
  constexpr double kPointsPerPiece = 4, kFewestPoints = 41, kMostPoints = 801;
  const double pieces =
      shape.kind == ShapeKind::harmonic ? 2 * shape.harmonic : static_cast<double>(shape.count);
  return static_cast<int>(std::clamp(kPointsPerPiece * pieces, kFewestPoints, kMostPoints));
}

}  // namespace armtrue
