#include "armtrue/kinematics/conventions.h"

#include <Eigen/Geometry>
#include <stdexcept>
#include <utility>

namespace armtrue {

Pose modified_from_standard(const Link& row) {
  return {Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX()).toRotationMatrix(),
          Eigen::Vector3d(row.d, 0, 0)};
}

KinematicChain from_standard(const KinematicChain& rows) {
  KinematicChain chain = rows;
  double alpha = 0, d = 0;  // of the row before
  for (Link& link : chain.links) {
    if (link.beta != 0)
      throw std::invalid_argument("the standard convention has no beta: link '" + link.name + "'");
    std::swap(link.alpha, alpha);
    std::swap(link.d, d);
  }
  chain.tool = modified_from_standard(rows.links.back()) * rows.tool;
  return chain;
}

}  // namespace armtrue
