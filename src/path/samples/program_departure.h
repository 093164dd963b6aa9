#pragma once

#include "armtrue/path/path.h"

namespace armtrue {

/// How far a run of samples departs from what its neighbours show [m].
struct Departure {
  double both = 0;  ///< from the prediction from both sides
  double side = 0;  ///< from the prediction from the better side
};

/// The largest departures of runs of `length` samples of the program itself, sampled every `period`
/// [s]: how far the program itself departs and returns in as short a time.
Departure largest_departure(const Path& programmed, double period, Eigen::Index length);

}  // namespace armtrue
