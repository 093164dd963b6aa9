#include "armtrue/kinematics/contact.h"

#include <algorithm>
#include <cmath>

namespace armtrue {
namespace {

// What a lens makes of the direction (x, y), its derivatives by it and by the intrinsics.
struct Distorted {
  Eigen::Vector2d at;
  Eigen::Matrix2d by_direction;
  Eigen::Matrix<double, 2, kIntrinsics> by_intrinsics =
      Eigen::Matrix<double, 2, kIntrinsics>::Zero();
};

Distorted by_pinhole(const Intrinsics& of, const Eigen::Vector2d& direction) {
  const double x = direction.x(), y = direction.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (of[kK1] + r2 * (of[kK2] + r2 * of[kK3]));
  const double slope = of[kK1] + r2 * (2 * of[kK2] + r2 * 3 * of[kK3]);  // of radial by r2
  const double p1 = of[kP1], p2 = of[kP2];
  Distorted distorted;
  distorted.at = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                  y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  const double mixed = 2 * (x * y * slope + p1 * x + p2 * y);
  distorted.by_direction << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, mixed,  //
      mixed, radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  distorted.by_intrinsics.col(kK1) = direction * r2;
  distorted.by_intrinsics.col(kK2) = direction * (r2 * r2);
  distorted.by_intrinsics.col(kK3) = direction * (r2 * r2 * r2);
  distorted.by_intrinsics.col(kP1) << 2 * x * y, r2 + 2 * y * y;
  distorted.by_intrinsics.col(kP2) << r2 + 2 * x * x, 2 * x * y;
  return distorted;
}

Distorted by_fisheye(const Intrinsics& of, const Eigen::Vector2d& direction) {
  constexpr double kNearAxis = 1e-8;  // the distortion goes with r^2, which is below rounding
  Distorted distorted;
  const double r = direction.norm();
  if (r < kNearAxis) {
    distorted.at = direction;
    distorted.by_direction.setIdentity();
    return distorted;
  }
  const double a = std::atan(r), a2 = a * a;
  const double series = 1 + a2 * (of[kK1] + a2 * (of[kK2] + a2 * (of[kK3] + a2 * of[kK4])));
  const double by_angle =
      1 + a2 * (3 * of[kK1] + a2 * (5 * of[kK2] + a2 * (7 * of[kK3] + a2 * 9 * of[kK4])));
  const double scale = a * series / r;
  const Eigen::Vector2d unit = direction / r;
  distorted.at = direction * scale;
  // d(n s(r) r) = s (I - n n^T) + (d(s r)/dr) n n^T, with n the unit vector.
  const Eigen::Matrix2d along = unit * unit.transpose();
  distorted.by_direction =
      scale * (Eigen::Matrix2d::Identity() - along) + by_angle / (1 + r * r) * along;
  distorted.by_intrinsics.col(kK1) = unit * (a * a2);
  distorted.by_intrinsics.col(kK2) = unit * (a * a2 * a2);
  distorted.by_intrinsics.col(kK3) = unit * (a * a2 * a2 * a2);
  distorted.by_intrinsics.col(kK4) = unit * (a * a2 * a2 * a2 * a2);
  return distorted;
}

}  // namespace

PixelReading project(Lens lens, const Intrinsics& intrinsics, const Eigen::Vector3d& u) {
  constexpr double kNearest = 1e-3;  // m
  const double depth = std::max(u.z(), kNearest);
  const Eigen::Vector2d direction = u.head<2>() / depth;
  const Distorted distorted =
      lens == Lens::pinhole ? by_pinhole(intrinsics, direction) : by_fisheye(intrinsics, direction);
  const Eigen::Vector2d focal = intrinsics.segment<2>(kFx);
  Eigen::Matrix<double, 2, 3> of_direction;
  of_direction << 1 / depth, 0, -direction.x() / depth, 0, 1 / depth, -direction.y() / depth;
  PixelReading reading;
  reading.pixel = focal.cwiseProduct(distorted.at) + intrinsics.segment<2>(kCx);
  reading.by_point = focal.asDiagonal() * distorted.by_direction * of_direction;
  reading.by_intrinsics = focal.asDiagonal() * distorted.by_intrinsics;
  reading.by_intrinsics(0, kFx) = distorted.at.x();
  reading.by_intrinsics(1, kFy) = distorted.at.y();
  reading.by_intrinsics(0, kCx) = reading.by_intrinsics(1, kCy) = 1;
  return reading;
}

bool is_in_image(const Contact& camera, const Eigen::Vector3d& u, double margin) {
  constexpr double kNearest = 1e-2;  // m; nothing nearer is in focus
  if (u.z() < kNearest) return false;
  const Eigen::Vector2d centre = camera.intrinsics.segment<2>(kCx);
  const Eigen::Vector2d size =
      camera.image_size.isZero() ? Eigen::Vector2d(2 * centre.array() + 1) : camera.image_size;
  const PixelReading seen = project(camera.lens, camera.intrinsics, u);
  const bool is_inside = (seen.pixel.array() >= margin).all() &&
                         (seen.pixel.array() <= size.array() - 1 - margin).all();
  // Outwards on the line from the middle the pixel moves outwards.
  const Eigen::Vector2d outwards = seen.by_point.leftCols<2>() * u.head<2>();
  return is_inside && outwards.dot(seen.pixel - centre) >= 0;
}

const ArtefactPoint& touched_part(const Contact& contact, int point) {
  static const Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  static const ArtefactPoint origin, plane{"", middle, ContactKind::plane},
      sphere{"", middle, ContactKind::sphere};
  switch (contact.kind) {
    case ContactKind::artefact:
      return contact.points[point];
    case ContactKind::plane:
      return plane;
    case ContactKind::sphere:
      return sphere;
    default:
      return origin;
  }
}

TouchReading touch_reading(const Contact& contact, int point, int axis, const Eigen::Vector3d& u) {
  const ArtefactPoint& part = touched_part(contact, point);
  const Eigen::Vector3d seen = u - part.position;
  switch (part.kind) {
    case ContactKind::point:
      return {seen[axis], Eigen::Vector3d::Unit(axis)};
    case ContactKind::plane:
      return {part.normal.dot(seen) - contact.radius, part.normal};
    default:
      return {seen.norm() - part.radius - contact.radius, seen.normalized()};
  }
}

BeamReading beam_reading(const Contact& contact, int point, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& along) {
  const ArtefactPoint& part = touched_part(contact, point);
  const double cosine = part.normal.dot(along);
  const double bounded = std::copysign(std::max(std::abs(cosine), kGrazing), cosine);
  BeamReading reading;
  reading.value = part.normal.dot(part.position - origin) / bounded;
  reading.hit = origin + reading.value * along;
  reading.gradient = -part.normal / bounded;
  return reading;
}

}  // namespace armtrue
