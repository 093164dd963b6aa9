#include "programs/krl_knots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "armtrue/programs/matching.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kBeside = std::numeric_limits<double>::quiet_NaN();

// t in [0, 1], or kBeside beyond the ends of the move. A t within the tolerance [share of the
// length] of an end is that end.
double within_move(double t, double tolerance) {
  if (!(t >= -tolerance && t <= 1 + tolerance)) return kBeside;
  return t <= tolerance ? 0 : t >= 1 - tolerance ? 1 : t;
}

double place_on_line(const Vector3d& start, const Vector3d& end, const Vector3d& sample) {
  const Vector3d chord = end - start;
  const double t = chord.dot(sample - start) / chord.squaredNorm();
  if ((start + t * chord - sample).norm() > kPathMatchTolerance) return kBeside;
  return within_move(t, kPathMatchTolerance / chord.norm());
}

double place_on_arc(const Arc& arc, const Vector3d& sample) {
  if (arc.distance(sample) > kPathMatchTolerance) return kBeside;
  const double share = kPathMatchTolerance / (arc.radius * arc.angle);
  const double t = arc.foot(sample), turn = 2 * std::numbers::pi / arc.angle;
  return within_move(t > turn - share ? t - turn : t, share);
}

// `place_on(sample)` returns t of a sample on the move, or kBeside.
template <class PlaceOn>
std::vector<Knot> knots_on(const KrlPlannedMove& plan, const Path& path,
                           const Eigen::Matrix3Xd& displacement, PlaceOn place_on) {
  const bool from_start = std::isfinite(plan.start_place), to_end = std::isfinite(plan.end_place);
  const auto begin = static_cast<Index>(std::ceil(plan.from));
  const auto end = std::min(static_cast<Index>(plan.to) + 1, path.samples());
  std::vector<Knot> inside;
  const auto add = [&](Index k) {
    const double t = place_on(path.position.col(k));
    if (t > 0 && t < 1) inside.push_back({t, displacement.col(k)});
    return std::isfinite(t);
  };
  if (from_start) {
    for (Index k = begin; k < end; ++k)
      if (!add(k) && !to_end) break;
  } else if (to_end) {
    for (Index k = end - 1; k >= begin; --k)
      if (!add(k)) break;
    std::reverse(inside.begin(), inside.end());
  }
  const auto at_end = [&](double place) -> Vector3d {
    return std::isfinite(place) ? at_place(displacement, place) : Vector3d::Zero();
  };
  std::vector<Knot> knots{{0, at_end(plan.start_place)}};
  for (const Knot& knot : inside)
    if (knot.t > knots.back().t) knots.push_back(knot);
  knots.push_back({1, at_end(plan.end_place)});
  return knots;
}

}  // namespace

std::vector<Knot> knots_on_line(const KrlPlannedMove& plan, const Path& path,
                                const Eigen::Matrix3Xd& displacement) {
  const Vector3d start = position(plan.start), end = position(plan.end);
  return knots_on(plan, path, displacement,
                  [&](const Vector3d& sample) { return place_on_line(start, end, sample); });
}

std::vector<Knot> knots_on_arc(const KrlPlannedMove& plan, const Arc& arc, const Path& path,
                               const Eigen::Matrix3Xd& displacement) {
  return knots_on(plan, path, displacement,
                  [&](const Vector3d& sample) { return place_on_arc(arc, sample); });
}

}  // namespace armtrue
