#include "armtrue/certification/path_figures.h"

#include "armtrue/path/accuracy.h"

namespace armtrue {

PathFigures path_figures(const Path& commanded, const std::vector<Path>& passes,
                         const ClockOptions& clock) {
  std::vector<Path> registered_passes;
  for (const Path& pass : passes)
    registered_passes.push_back(registered(pass, fit_clock(commanded, pass, clock)));
  const PathAccuracy found = pass_accuracy(commanded, registered_passes).path;
  return {static_cast<int>(passes.size()), found.planes, found.at, found.rt, clock.fit_frame};
}

}  // namespace armtrue
