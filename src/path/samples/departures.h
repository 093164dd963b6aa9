#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A record without its departed samples: short runs that depart from what the samples before, the
/// samples after and both together show.
struct WithoutDepartures {
  std::vector<Eigen::Index> good;
  /// A sample that differs by no more from the line between its good neighbours is good too [m].
  double tolerance = 0;
};

/// Filters a record that is not registered yet. `speed`: the greatest of the program [m/s];
/// `rounding`: standard deviation of the rounding of the instrument, which a median may not show
/// [m]; `good`: the samples that are not known to be bad.
WithoutDepartures without_departures(const Path& programmed, const Path& measured, double speed,
                                     double rounding, std::vector<Eigen::Index> good);

/// Filters deviations from the positions `wanted`. They change little, so that more neighbours are
/// used.
WithoutDepartures without_departures(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                     double rounding, std::vector<Eigen::Index> good);

}  // namespace armtrue
