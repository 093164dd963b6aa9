#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/path/registration/clock.h"

namespace armtrue {

/// Least squares for a small motion of the frame (ClockFit::by_frame()), three rows for each
/// sample, zero for samples at standstill. The rows of a sample are weighted by I - 0.7 u u', u the
/// direction of motion: the deviation across the path counts. Of a record with forces, what a
/// compliance explains is taken off: a steady force bends the arm as if its frame were displaced.
struct FrameEquations {
  Eigen::VectorXd deviation;  ///< weighted [m]
  Eigen::MatrixX3d weight;
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_frame;  ///< weighted

  /// by_frame' by_frame, and a millionth more for what a path does not show, such as a turn about
  /// a straight line.
  Eigen::Matrix<double, 6, 6> information() const;
};
FrameEquations frame_equations(const Path& programmed, const Path& measured, const ClockFit& fit);

/// The frame near `start`, one for all passes, in which the weighted mean square deviation is
/// smallest. The deviation d loses its projection Pd on the motions of a frame, and a correction of
/// the rest leaves Pd, which is not larger than d in that mean square. Generalised least squares
/// with the fitted process are an oblique projection, which has no such bound: they compare
/// differences of neighbours, and a smooth deviation makes those as a turn does.
Pose fit_frame(const Path& programmed, const std::vector<Path>& passes,
               const std::vector<ClockFit>& clocks, const Pose& start);

}  // namespace armtrue
