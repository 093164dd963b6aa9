#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// Largest RMS form error of a machined part [m], from the application in the seed paper.
inline constexpr double kFormGoal = 0.050e-3;

/// Intersections of a pass with the planes normal to the commanded path.
struct PlaneCrossings {
  std::vector<Eigen::Index> sample;  ///< samples of the commanded path whose planes are met,
                                     ///< increasing
  Eigen::Matrix3Xd deviation;        ///< in the plane, from that sample to the pass [m]
};

/// Intersects a measured pass, a polygon in the clock of `command`, with the plane through each
/// sample of `command` normal to its tangent. Among several intersections the nearest in time
/// counts, within 0.5 s. An intersection that is nearer to `command` at its own time than to the
/// sample belongs to another part of the path and does not count; so |deviation| is at most 1.04
/// times the distance at equal times. A sample at standstill has no plane; at a corner the tangent
/// is the mean of both sides. Throws std::invalid_argument if either path has fewer than two
/// samples.
PlaneCrossings cross_normal_planes(const Path& command, const Path& measured);

/// Path accuracy and repeatability, ISO 9283:1998, 8.2 and 8.3, position. In plane i let p_ij be
/// the intersection of pass j of n, b_i their barycentre, c_i the command, l_ij = |p_ij - b_i|:
///     AT_p = max_i |b_i - c_i|,    RT_p = max_i (mean_j l_ij + 3 S_i),
/// with S_i the standard deviation of l_ij over j (n - 1). The standard asks for n = 10; with one
/// pass AT_p is its largest deviation. Both contain the noise of the instrument.
struct PathAccuracy {
  double at = 0;             ///< [m]
  std::optional<double> rt;  ///< [m]; empty for one pass
  /// Standard deviation of a pass about the barycentre, per axis of a plane, of all planes
  /// together: sqrt(sum_ij l_ij^2 / (2 (n - 1) planes)) [m]; 0 for one pass.
  double scatter = 0;
  int planes = 0;  ///< met by all passes; the others do not count
};

/// `passes`: cross_normal_planes() of each. Throws std::invalid_argument if there is none, or no
/// plane that all of them meet.
PathAccuracy path_accuracy(const std::vector<PlaneCrossings>& passes);

/// The same of passes in the clock and the frame of `command`. Throws as cross_normal_planes()
/// does, too.
PathAccuracy path_accuracy(const Path& command, const std::vector<Path>& passes);

/// Mean, RMS, 95th percentile and maximum of |deviation| per axis and of its length [m].
struct PathErrors {
  std::array<ErrorSummary, 3> axis;
  ErrorSummary whole;
};

/// `deviation` 3 x n [m]. For a form goal see form_error().
PathErrors path_errors(const Eigen::Matrix3Xd& deviation);

/// 1 - after / before of the mean errors (table 6 of the seed paper): negative if an error grew,
/// empty if it was zero before.
struct Reduction {
  std::array<std::optional<double>, 3> axis;  ///< of the mean |deviation| of each axis
  std::optional<double> whole;                ///< of the mean length, not the mean of the axes
};

Reduction reduction(const PathErrors& before, const PathErrors& after);

}  // namespace armtrue
