#include "armtrue/certification/path_figures.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "armtrue/path/accuracy.h"

namespace armtrue {
namespace {

// See PathFigures::at_of_frame.
double at_of_frame(const Path& commanded, const ClockFit& clock) {
  const Eigen::Matrix3Xd tangent = tangents(commanded);
  double largest = 0;
  for (Eigen::Index i = 0; i < commanded.samples(); ++i) {
    const Eigen::Matrix3d project =
        Eigen::Matrix3d::Identity() - tangent.col(i) * tangent.col(i).transpose();
    const Eigen::Matrix<double, 3, 6> across = project * clock.by_frame(commanded.position.col(i));
    const Eigen::Matrix3d covariance = across * clock.frame_covariance * across.transpose();
    largest = std::max(
        largest, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
                     .eigenvalues()[2]);
  }
  return std::sqrt(largest);
}

}  // namespace

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
  figures.clocks = clocks;
  figures.planes = found.planes;
  figures.of_path = cross_normal_planes(commanded, commanded).sample.size();
  figures.at = found.at;
  figures.rt = found.rt;
  for (const Path& pass : passes)
    figures.range = std::max(figures.range, pass.position.colwise().norm().maxCoeff());
  figures.frame_is_fitted = clock.fit_frame;
  if (clock.fit_frame) figures.at_of_frame = at_of_frame(commanded, clocks.front());
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
