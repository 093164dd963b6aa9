#include "programs/way.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace armtrue {

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
