#include "armtrue/kinematics/contact.h"

namespace armtrue {

TouchReading touch_reading(const Contact& contact, int point, int axis, const Eigen::Vector3d& u) {
  switch (contact.kind) {
    case ContactKind::point:
      return {u[axis], Eigen::Vector3d::Unit(axis)};
    case ContactKind::artefact:
      return {u[axis] - contact.points[point].position[axis], Eigen::Vector3d::Unit(axis)};
    case ContactKind::plane:
      return {u.z(), Eigen::Vector3d::UnitZ()};
    case ContactKind::sphere:
      break;
  }
  return {u.norm() - contact.radius, u.normalized()};
}

}  // namespace armtrue
