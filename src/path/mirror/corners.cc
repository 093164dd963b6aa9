#include "path/mirror/corners.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr double kMinCornerAngle = 15 * kDegree;  // between neighbouring samples
constexpr Eigen::Index kMaxSharp = 2;  // samples over which central differences see a corner
constexpr double kMinSine = 1e-3;      // below it the sides are parallel
constexpr double kMaxMitre = 2;        // of the larger displacement
constexpr double kReach = 10;          // length of a side that is shifted, over the shift

double distance_to_line(const Eigen::Vector3d& point, const Eigen::Vector3d& on,
                        const Eigen::Vector3d& direction) {
  return (point - on).cross(direction).norm();
}

// a, b that minimise |a * along_a - b * along_b - step|; zero for parallel lines.
Eigen::Vector2d between_lines(const Eigen::Vector3d& along_a, const Eigen::Vector3d& along_b,
                              const Eigen::Vector3d& step) {
  const double cosine = along_a.dot(along_b), square = 1 - cosine * cosine;
  if (square < kMinSine * kMinSine) return Eigen::Vector2d::Zero();
  const double a = along_a.dot(step), b = along_b.dot(step);
  return Eigen::Vector2d(a - cosine * b, cosine * a - b) / square;
}

}  // namespace

std::vector<Corner> find_corners(const Path& path) {
  const Eigen::Matrix3Xd tangent = tangents(path);
  const Eigen::Index end = path.samples();
  const double cosine = std::cos(kMinCornerAngle);
  const auto turns = [&](Eigen::Index i) {
    return tangent.col(i).dot(tangent.col(i - 1)) < cosine;
  };
  std::vector<Corner> corners;
  for (Eigen::Index i = 1; i < end; ++i) {
    if (!turns(i)) continue;
    const Eigen::Index first = i;
    while (i + 1 < end && turns(i + 1)) ++i;
    if (i - first > kMaxSharp) continue;  // a tight curve
    const Eigen::Index a = std::max<Eigen::Index>(first - 2, 0), b = std::min(i + 1, end - 1);
    Corner corner{a, path.position.col(a), tangent.col(a), tangent.col(b)};
    if (corner.before.dot(corner.after) > cosine) continue;
    const Eigen::Vector3d from = path.position.col(a), to = path.position.col(b);
    corner.vertex += between_lines(corner.before, corner.after, to - from)[0] * corner.before;
    for (Eigen::Index k = a + 1; k < b; ++k) {
      const Eigen::Vector3d here = path.position.col(k);
      if (distance_to_line(here, from, corner.before) <= distance_to_line(here, to, corner.after))
        corner.last = k;
    }
    corners.push_back(corner);
  }
  return corners;
}

Eigen::Matrix3Xd side_tangents(const Path& path, const std::vector<Corner>& corners) {
  Eigen::Matrix3Xd tangent = tangents(path);
  for (const Corner& corner : corners)
    for (Eigen::Index k = 0; k <= kMaxSharp; ++k) {
      if (corner.last >= k) tangent.col(corner.last - k) = corner.before;
      if (corner.last + 1 + k < path.samples()) tangent.col(corner.last + 1 + k) = corner.after;
    }
  return tangent;
}

Eigen::Matrix3Xd without_along(const Path& path, const std::vector<Corner>& corners,
                               Eigen::Matrix3Xd vectors) {
  const Eigen::Matrix3Xd tangent = side_tangents(path, corners);
  for (Eigen::Index i = 0; i < vectors.cols(); ++i)
    vectors.col(i) -= tangent.col(i).dot(vectors.col(i)) * tangent.col(i);
  return vectors;
}

void join_sides(const Path& path, const std::vector<Corner>& corners,
                Eigen::Matrix3Xd& displacement) {
  if (corners.empty()) return;
  const Eigen::Matrix3Xd tangent = side_tangents(path, corners);
  const Eigen::Matrix3Xd across = displacement;
  const Eigen::VectorXd length = arc_length(path);
  for (size_t k = 0; k < corners.size(); ++k) {
    const Corner& corner = corners[k];
    const Eigen::Vector3d before = across.col(corner.last), after = across.col(corner.last + 1);
    const Eigen::Vector2d along = between_lines(corner.before, corner.after, after - before);
    const double mitre = kMaxMitre * std::max(before.norm(), after.norm());
    // Two corners on one side share it half and half.
    const Eigen::Index first = k > 0 ? (corners[k - 1].last + 1 + corner.last) / 2 : 0;
    const Eigen::Index end =
        k + 1 < corners.size() ? (corner.last + 1 + corners[k + 1].last) / 2 : path.samples() - 1;
    const double at =
        length[corner.last] + (corner.vertex - path.position.col(corner.last)).dot(corner.before);
    const auto shift = [&](double by, double room, Eigen::Index from, Eigen::Index to, int step) {
      by = std::clamp(by, -std::min(mitre, room / 2), std::min(mitre, room / 2));
      const double reach = std::min(kReach * std::abs(by), room);
      for (Eigen::Index i = from; i != to + step; i += step) {
        const double left = 1 - std::abs(length[i] - at) / reach;
        if (!(left > 0)) break;
        displacement.col(i) += by * left * tangent.col(i);
      }
    };
    shift(along[0], at - length[first], corner.last, first, -1);
    shift(along[1], length[end] - at, corner.last + 1, end, 1);
  }
}

}  // namespace armtrue
