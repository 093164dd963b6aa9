#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "armtrue/path/path.h"

namespace armtrue {

/// A record that runs beside the program by a constant distance, as the edge of a tool does beside
/// its centre.
struct Aside {
  double left;           ///< median distance to the left of travel [m]; negative: to the right
  double within;         ///< nine of ten samples differ from it by less [m]
  Eigen::Vector3d from;  ///< where one looks from: the normal of the plane of the program
  double shorter;        ///< by which the record's way is shorter on its curves and corners [m]

  /// Whether the record passes a part of the program `earlier` than it should [m of way], and the
  /// distance explains more than half of that.
  bool explains(double earlier) const;
};

/// From the nearest places of the program: needs no clock. Present if nine of ten samples lie
/// within a third of the median distance, and a shift of the record explains them at most half as
/// well. Nothing for a straight program, of which a shift does the same, and for one that leaves
/// its plane.
std::optional<Aside> find_aside(const Path& programmed, const Path& measured);

/// "runs 5 mm to the left of travel all along (seen from +z), ..." with the remedy.
std::string in_words(const Aside& aside);

}  // namespace armtrue
