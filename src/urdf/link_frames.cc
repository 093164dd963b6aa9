#include "urdf/link_frames.h"

#include <Eigen/Geometry>
#include <cmath>

namespace armtrue {

using Eigen::Vector3d;

Eigen::Matrix3d rotation_before(const Link& link) {
  using Eigen::AngleAxisd;
  return (AngleAxisd(link.beta, Vector3d::UnitY()) * AngleAxisd(link.alpha, Vector3d::UnitX()))
      .toRotationMatrix();
}

Pose link_transform(const Link& link) {
  const Eigen::Matrix3d before = rotation_before(link);
  Pose pose;
  pose.rotation = before * Eigen::AngleAxisd(link.theta, Vector3d::UnitZ()).toRotationMatrix();
  pose.translation = before * Vector3d(link.d, 0, link.r);
  return pose;
}

Vector3d roll_pitch_yaw(const Eigen::Matrix3d& rotation) {
  const Vector3d abc = abc_from_rotation(rotation);
  const double cos_pitch = std::hypot(rotation(0, 0), rotation(1, 0));
  if (cos_pitch > 1e-3 || cos_pitch < 1e-12) return {abc[2], abc[1], abc[0]};
  const double cos_yaw = std::cos(abc[0]), sin_yaw = std::sin(abc[0]);
  const double roll = std::atan2(sin_yaw * rotation(0, 2) - cos_yaw * rotation(1, 2),
                                 cos_yaw * rotation(1, 1) - sin_yaw * rotation(0, 1));
  return {roll, abc[1], abc[0]};
}

namespace {

// Axes that meet at a smaller angle [rad] are described by Hayati's beta: their common normal would
// lie far away, or anywhere.
constexpr double kNearlyParallel = 0.02;

}  // namespace

Pose frame_towards(const JointAxis& own, const JointAxis& next, const Pose& previous) {
  const Vector3d normal = own.direction.cross(next.direction);
  Vector3d x, origin;
  if (normal.norm() > kNearlyParallel) {
    x = normal.normalized();
    // Foot of the common normal.
    const Vector3d across = next.direction.cross(x);
    origin = own.point +
             own.direction * ((next.point - own.point).dot(across) / own.direction.dot(across));
  } else {
    const auto across = [&](const Vector3d& v) {
      return Vector3d(v - own.direction * own.direction.dot(v));
    };
    origin = previous.translation - across(previous.translation - own.point);
    const Vector3d to_next = next.point - origin;
    const Vector3d foot = to_next - next.direction * next.direction.dot(to_next);
    // Without such a direction, where `next` passes through the origin, x stays that of `previous`.
    x = (across(foot).norm() > 1e-9 ? across(foot) : across(previous.rotation.col(0))).normalized();
  }
  Pose frame;
  frame.rotation << x, own.direction.cross(x), own.direction;
  frame.translation = origin;
  return frame;
}

Link link_along(const Vector3d& z) {
  Link link;
  if (std::abs(z.x()) < 1e-12) {
    link.alpha = std::atan2(-z.y(), z.z());
  } else {
    const double side = z.z() < 0 ? -1 : 1;
    link.alpha = std::atan2(-z.y(), side * std::hypot(z.x(), z.z()));
    link.beta = std::atan2(side * z.x(), side * z.z());
  }
  return link;
}

Link link_between(const Pose& previous, const Pose& frame) {
  const Pose relative = inverse(previous) * frame;
  Link link = link_along(relative.rotation.col(2));
  const Eigen::Matrix3d before = rotation_before(link);
  const Vector3d x = before.transpose() * relative.rotation.col(0);
  link.theta = std::atan2(x.y(), x.x());
  const Vector3d moved = before.transpose() * relative.translation;
  link.d = moved.x();
  link.r = moved.z();
  return link;
}

}  // namespace armtrue
