#include "programs/krl_pose.h"

#include "armtrue/kinematics/pose.h"

namespace armtrue {

KrlValues between(const KrlValues& start, const KrlValues& end, double t) {
  KrlValues pose = start + t * (end - start);
  const Eigen::Vector3d from = start.segment<3>(3), to = end.segment<3>(3);
  if (from.allFinite() && to.allFinite() && from != to) {
    const Eigen::Matrix3d rotation = rotation_from_abc(from[0], from[1], from[2]);
    const Eigen::Vector3d turn =
        rotation_log(rotation.transpose() * rotation_from_abc(to[0], to[1], to[2]));
    pose.segment<3>(3) = abc_from_rotation(rotation * rotation_exp(t * turn));
  }
  return pose;
}

}  // namespace armtrue
