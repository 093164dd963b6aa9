#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// What is left of the samples of a record without those that neither side explains.
struct WithoutDepartures {
  std::vector<Eigen::Index> good;
  double tolerance = 0;  ///< of samples that differ from their good neighbours by chance only [m]
};

/// Of a record as it is: how the program moves at a sample is not known yet, only how fast it moves
/// anywhere [m/s]. `rounding`: part of the noise that the record may not show [m]; `good`: the
/// samples that are not known to be bad.
WithoutDepartures without_departures(const Path& programmed, const Path& measured, double speed,
                                     double rounding, std::vector<Eigen::Index> good);

/// Of deviations from `wanted`, which change little: more neighbours tell where the tool was.
WithoutDepartures without_departures(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                     double rounding, std::vector<Eigen::Index> good);

}  // namespace armtrue
