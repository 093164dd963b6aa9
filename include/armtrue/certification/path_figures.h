#pragma once

#include <array>
#include <optional>
#include <vector>

#include "armtrue/certification/pose_accuracy.h"
#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// Cycles of a path that ISO 9283:1998 asks for.
inline constexpr int kStandardPathCycles = 10;

/// ISO 9283:1998, 8.2 and 8.3, of one commanded path, position: see PathAccuracy.
struct PathFigures {
  int passes = 0;
  std::vector<ClockFit> clocks;  ///< of the passes
  Eigen::Index planes = 0;   ///< normal to the path, met by all passes
  Eigen::Index of_path = 0;  ///< those of the whole path
  double at = 0;             ///< [m]
  std::optional<double> rt;  ///< [m]; empty for one pass
  /// 95 % interval of the RT that many passes would show, see repeatability_ci95() [m]; empty below
  /// three passes.
  std::optional<std::array<double, 2>> rt_ci95;
  /// The AT of an exact path with this scatter s: s / sqrt(n) sqrt(2 log planes), the largest of as
  /// many independent planes [m]. Zero for one pass.
  double at_of_scatter = 0;
  /// Scatter of a pass, per axis [m]. Neighbouring planes share their errors, so it has the degrees
  /// of freedom of one plane, 2 (n - 1).
  Scatter scatter;
  /// Farthest sample of a pass from the origin of its frame, where instruments stand that read in
  /// their own frame [m].
  double range = 0;
  bool frame_is_fitted = false;
  /// Standard uncertainty of the deviation in a plane by a fitted frame, in the plane and the
  /// direction where it is largest [m]: the frame takes up what of the deviation looks like a
  /// motion of it.
  double at_of_frame = 0;
  /// Whether all passes meet 99 % of the planes; at the ends of the path a pass may miss some.
  bool is_whole() const { return 100 * (of_path - planes) <= of_path; }
  std::optional<double> rt_expanded() const {  ///< [m]
    return rt ? expanded_of(*rt, rt_ci95) : std::nullopt;
  }
};

/// `passes`: as the instrument recorded them. The clock of each is fitted, and the frame of the
/// instrument, one for all passes, if `clock` asks for it. Throws std::invalid_argument as
/// fit_clocks() and path_accuracy() do.
PathFigures path_figures(const Path& commanded, const std::vector<Path>& passes,
                         const ClockOptions& clock);

}  // namespace armtrue
