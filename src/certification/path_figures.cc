#include "armtrue/certification/path_figures.h"

#include <cmath>

#include "armtrue/path/accuracy.h"

namespace armtrue {

PathFigures path_figures(const Path& commanded, const std::vector<Path>& passes,
                         const ClockOptions& clock) {
  std::vector<Path> registered_passes;
  const std::vector<ClockFit> clocks = fit_clocks(commanded, passes, clock);
  for (size_t p = 0; p < passes.size(); ++p)
    registered_passes.push_back(registered(passes[p], clocks[p]));
  const PathAccuracy found = path_accuracy(commanded, registered_passes);
  const auto n = static_cast<int>(passes.size());
  PathFigures figures;
  figures.passes = n;
  figures.planes = found.planes;
  figures.of_path = cross_normal_planes(commanded, commanded).sample.size();
  figures.at = found.at;
  figures.rt = found.rt;
  figures.frame_is_fitted = clock.fit_frame;
  if (n < 2) return figures;
  const double size = commanded.position.cwiseAbs().maxCoeff();
  figures.rt = resolved(*found.rt, size);
  figures.scatter = {resolved(found.scatter, size), 2.0 * (n - 1)};
  figures.at_of_scatter =
      figures.scatter.deviation / std::sqrt(n) * std::sqrt(2 * std::log(found.planes));
  if (n < 3) return figures;
  const Eigen::Matrix3d in_plane = Eigen::Vector3d(1, 1, 0).asDiagonal();
  figures.rt_ci95 = repeatability_ci95(*figures.rt, n, found.planes, in_plane);
  return figures;
}

}  // namespace armtrue
