#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "armtrue/path/mirror/engagement.h"
#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"
#include "armtrue/path/samples/bad_samples.h"

namespace armtrue {

/// How a record was registered to its program.
struct Pass {
  ClockFit clock;
  int samples = 0;
  int lost = 0;                ///< samples missing between the first and the last
  std::vector<BadSample> bad;  ///< of the record; they are left out
  double longest_gap = 0;      ///< between the samples that are left [s]
};

/// Mean deviation (measured minus programmed) of the passes, on a uniform grid of program times.
struct PathDeviation {
  double period = 0;           ///< [s]
  Eigen::VectorXd time;        ///< of the program [s]
  Eigen::VectorXd arc_length;  ///< of the program [m]
  Eigen::Matrix3Xd normal;     ///< part across the programmed path [m]
  Eigen::VectorXd along;       ///< part in the direction of motion [m]; it is not corrected
  Eigen::Matrix3Xd whole;      ///< sum of both [m]
  Eigen::Matrix3Xd force;      ///< [N]; no columns if a record has none
  Eigen::Matrix3Xd trend;      ///< `normal` smoothed piece by piece [m]
  /// First sample of each piece after the first one: there `normal` jumps, as at a corner, a
  /// reversal, an entry or an exit.
  std::vector<Eigen::Index> breaks;
  EngagementRecord engagement;  ///< from the force or, without one, from `normal`
  double noise = 0;             ///< standard deviation of one sample of `normal`, per axis [m]
  double spread = 0;  ///< standard deviation from pass to pass, per axis [m]; 0 for a single pass
  std::array<double, 2> spread_ci95{0, 0};  ///< of these passes: what their noise leaves open [m]
  /// Covariance of the mean clock of the passes: its offset halfway through `time` [s], and its
  /// rate.
  Eigen::Matrix2d clock_covariance = Eigen::Matrix2d::Zero();
};

}  // namespace armtrue
