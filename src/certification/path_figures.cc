#include "armtrue/certification/path_figures.h"

#include "armtrue/path/accuracy.h"

namespace armtrue {

PathFigures path_figures(const Path& commanded, const std::vector<Path>& passes,
                         const ClockOptions& clock) {
  std::vector<Path> registered_passes;
  for (const Path& pass : passes)
    registered_passes.push_back(registered(pass, fit_clock(commanded, pass, clock)));
  const PathAccuracy found = pass_accuracy(commanded, registered_passes).path;
  const auto n = static_cast<int>(passes.size());
  PathFigures figures;
  figures.passes = n;
  figures.planes = found.planes;
  figures.of_path =
      static_cast<Eigen::Index>(cross_normal_planes(commanded, commanded).sample.size());
  figures.at = found.at;
  figures.rt = found.rt;
  figures.frame_is_fitted = clock.fit_frame;
  if (n < 2) return figures;
  const double size = commanded.position.cwiseAbs().maxCoeff();
  figures.rt = resolved(*found.rt, size);
  figures.rt_std = repeatability_std(resolved(found.rt_deviation, size), n);
  figures.scatter = {resolved(found.scatter, size), 2.0 * (n - 1)};
  return figures;
}

}  // namespace armtrue
