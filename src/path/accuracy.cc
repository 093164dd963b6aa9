#include "armtrue/path/accuracy.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr double kMaxTimeApart = 0.5;  // [s] between a plane and its intersection

struct Plane {
  Eigen::Vector3d point, normal;
  double time;
};

struct Intersection {
  Eigen::Vector3d point;
  double time;
};

// Intersection of the plane with segment s of the pass, from sample s to s + 1.
std::optional<Intersection> meet(const Plane& plane, const Path& pass, Eigen::Index s) {
  const Eigen::Vector3d from = pass.position.col(s), to = pass.position.col(s + 1);
  const double a = plane.normal.dot(from - plane.point), b = plane.normal.dot(to - plane.point);
  if ((a > 0 && b > 0) || (a < 0 && b < 0) || a == b) return std::nullopt;
  const double share = a / (a - b);
  return Intersection{from + (to - from) * share,
                      pass.time[s] + (pass.time[s + 1] - pass.time[s]) * share};
}

// Beside a corner a plane may miss its own leg and meet the next one. Such a point is nearer to
// where the command is at the time of the point than to the sample of the plane. On one leg the
// sample of the plane is the nearest, but for the angle between the sides of a polygon.
bool is_of_another_leg(const Intersection& met, const Plane& plane, const Path& command) {
  static const double kShorter = std::cos(15 * kDegree);  // no curve turns more at one sample
  const Eigen::Vector3d then = position_at(command, Eigen::VectorXd::Constant(1, met.time));
  return (met.point - then).norm() < kShorter * (met.point - plane.point).norm();
}

// The intersection nearest in time: searches outwards from segment `start`, which holds the time of
// the plane.
std::optional<Eigen::Vector3d> meet_nearest(const Plane& plane, const Path& command,
                                            const Path& pass, Eigen::Index start) {
  Eigen::Index below = start, above = start + 1;
  const Eigen::Index segments = pass.samples() - 1;
  const auto time_apart = [&](Eigen::Index s) {
    return std::max({pass.time[s] - plane.time, plane.time - pass.time[s + 1], 0.0});
  };
  while (true) {
    const double back = below >= 0 ? time_apart(below) : 2 * kMaxTimeApart;
    const double ahead = above < segments ? time_apart(above) : 2 * kMaxTimeApart;
    if (std::min(back, ahead) > kMaxTimeApart) return std::nullopt;
    const Eigen::Index s = back <= ahead ? below-- : above++;
    const auto met = meet(plane, pass, s);
    if (met && !is_of_another_leg(*met, plane, command)) return met->point;
  }
}

}  // namespace

PlaneCrossings cross_normal_planes(const Path& command, const Path& measured) {
  if (command.samples() < 2 || measured.samples() < 2)
    throw std::invalid_argument("path accuracy: a path needs two samples");
  const Eigen::Matrix3Xd tangent = tangents(command);
  PlaneCrossings crossings;
  crossings.deviation.resize(3, command.samples());
  Eigen::Index segment = 0;
  for (Eigen::Index i = 0; i < command.samples(); ++i) {
    const bool stands =
        i > 0 && (command.position.col(i) - command.position.col(i - 1)).norm() <= kStandstill;
    if (stands || tangent.col(i).isZero()) continue;
    const Plane plane{command.position.col(i), tangent.col(i), command.time[i]};
    while (segment + 2 < measured.samples() && measured.time[segment + 1] < plane.time) ++segment;
    const auto point = meet_nearest(plane, command, measured, segment);
    if (!point) continue;
    crossings.deviation.col(crossings.sample.size()) = *point - plane.point;
    crossings.sample.push_back(i);
  }
  crossings.deviation.conservativeResize(Eigen::NoChange, crossings.sample.size());
  return crossings;
}

PathAccuracy path_accuracy(const std::vector<PlaneCrossings>& passes) {
  if (passes.empty()) throw std::invalid_argument("path accuracy: no pass");
  const Eigen::Index n = passes.size();
  PathAccuracy accuracy;
  std::vector<size_t> next(passes.size(), 0);
  double squares = 0;
  for (const Eigen::Index sample : passes.front().sample) {
    Eigen::Matrix3Xd met(3, n);
    bool all = true;
    for (size_t j = 0; j < passes.size(); ++j) {
      const std::vector<Eigen::Index>& samples = passes[j].sample;
      while (next[j] < samples.size() && samples[next[j]] < sample) ++next[j];
      all = all && next[j] < samples.size() && samples[next[j]] == sample;
      if (all) met.col(j) = passes[j].deviation.col(next[j]);
    }
    if (!all) continue;
    ++accuracy.planes;
    const Eigen::Vector3d barycentre = met.rowwise().mean();
    accuracy.at = std::max(accuracy.at, barycentre.norm());
    if (n < 2) continue;
    const Eigen::VectorXd radius = (met.colwise() - barycentre).colwise().norm().transpose();
    const double mean = radius.mean();
    const double deviation =
        std::sqrt((radius.array() - mean).square().sum() / static_cast<double>(n - 1));
    squares += radius.squaredNorm();
    if (accuracy.rt && mean + 3 * deviation <= *accuracy.rt) continue;
    accuracy.rt = mean + 3 * deviation;
  }
  if (accuracy.planes == 0)
    throw std::invalid_argument("path accuracy: no plane that all passes meet");
  if (n > 1)
    accuracy.scatter = std::sqrt(squares / static_cast<double>(2 * (n - 1) * accuracy.planes));
  return accuracy;
}

PathErrors path_errors(const Eigen::Matrix3Xd& deviation) {
  const auto summary = [](const Eigen::VectorXd& sizes) {
    return summarize({sizes.begin(), sizes.end()});
  };
  PathErrors errors;
  for (Eigen::Index a = 0; a < 3; ++a)
    errors.axis[a] = summary(deviation.row(a).cwiseAbs().transpose());
  errors.whole = summary(deviation.colwise().norm().transpose());
  return errors;
}

PathAccuracy path_accuracy(const Path& command, const std::vector<Path>& passes) {
  std::vector<PlaneCrossings> crossings;
  for (const Path& pass : passes) crossings.push_back(cross_normal_planes(command, pass));
  return path_accuracy(crossings);
}

Reduction reduction(const PathErrors& before, const PathErrors& after) {
  const auto gone = [](const ErrorSummary& b, const ErrorSummary& a) -> std::optional<double> {
    constexpr double kMinError = 1e-9;  // [m]: less is rounding
    if (b.mean < kMinError) return std::nullopt;
    return 1 - a.mean / b.mean;
  };
  Reduction result;
  for (size_t a = 0; a < 3; ++a) result.axis[a] = gone(before.axis[a], after.axis[a]);
  result.whole = gone(before.whole, after.whole);
  return result;
}

}  // namespace armtrue
