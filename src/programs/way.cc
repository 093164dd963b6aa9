#include "armtrue/programs/way.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace armtrue {

Eigen::Vector3d Arc::at(double t) const {
  return centre + radius * (std::cos(t * angle) * x + std::sin(t * angle) * y);
}

double Arc::foot(const Eigen::Vector3d& point) const {
  const double turned = std::atan2(y.dot(point - centre), x.dot(point - centre));
  return (turned < 0 ? turned + kTurn : turned) / angle;
}

double Arc::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d from = point - centre;
  const double out = x.cross(y).dot(from);
  return std::hypot(out, std::hypot(x.dot(from), y.dot(from)) - radius);
}

std::optional<Arc> arc_through(const Eigen::Vector3d& start, const Eigen::Vector3d& via,
                               const Eigen::Vector3d& end) {
  const Eigen::Vector3d a = via - start, b = end - start;
  const Eigen::Vector3d normal = a.cross(b);
  const double sine = normal.norm() / (a.norm() * b.norm());
  constexpr double kMinSine = 1e-9;
  if (!(sine > kMinSine)) return std::nullopt;
  Arc arc;
  arc.centre = start + (a.squaredNorm() * b - b.squaredNorm() * a).cross(normal) /
                           (2 * normal.squaredNorm());
  arc.radius = (start - arc.centre).norm();
  arc.x = (start - arc.centre) / arc.radius;
  arc.y = normal.normalized().cross(arc.x);
  arc.angle = 1;
  arc.angle = arc.foot(end);
  return arc;
}

Pose Way::at(double t) const {
  const auto turned = [&](double share) -> Eigen::Matrix3d {
    if (!arc || turning != ArcTurning::with_path) return Eigen::Matrix3d::Identity();
    return rotation_exp(share * arc->angle * arc->x.cross(arc->y));
  };
  const Eigen::Vector3d turn =
      rotation_log(start.rotation.transpose() * turned(1).transpose() * end.rotation);
  return {turned(t) * start.rotation * rotation_exp(t * turn),
          arc ? arc->at(t) : start.translation + t * (end.translation - start.translation)};
}

std::vector<double> external_between(const ProgramTarget& start, const ProgramTarget& end,
                                     double t) {
  std::vector<double> external(std::min(start.external.size(), end.external.size()));
  for (size_t i = 0; i < external.size(); ++i)
    external[i] = start.external[i] + t * (end.external[i] - start.external[i]);
  return external;
}

double passing_radius(double before, double behind, double of_last, double of_next) {
  constexpr double kSmallest = 1e-5, kLargest = 1e-2;  // [m]
  return std::max(kSmallest, std::min({kPassingShare * before, kPassingShare * behind,
                                       behind - of_next, before - of_last, kLargest}));
}

double Way::length() const {
  return arc ? arc->radius * arc->angle : (end.translation - start.translation).norm();
}

}  // namespace armtrue
