#include "armtrue/kinematics/conventions.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
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

namespace {

constexpr double kParallelAxes = 1e-9;  // sine of their angle: they have many common normals
constexpr double kSamePlace = 1e-9;     // m

// The pose as Rot(z, turn) Trans(z, shift) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r): the
// first two belong to the joint before the link.
struct BehindJoint {
  double turn = 0, shift = 0;
  Link link;
};

BehindJoint behind_joint(const Pose& pose) {
  const Eigen::Vector3d axis = pose.rotation.col(2), p = pose.translation;
  BehindJoint result;
  const double sine = std::hypot(axis.x(), axis.y());
  if (sine > kParallelAxes)
    result.turn = std::atan2(axis.x(), -axis.y());
  else if (std::hypot(p.x(), p.y()) > kSamePlace)
    result.turn = std::atan2(p.y(), p.x());
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(-result.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d place = turned * p;
  Link& link = result.link;
  link.joint = JointKind::fixed;
  link.d = place.x();
  if (sine > kParallelAxes) {
    link.alpha = std::atan2(sine, axis.z());
    link.r = -place.y() / sine;
  } else if (axis.z() < 0) {
    link.alpha = std::numbers::pi;
  }
  result.shift = place.z() - link.r * std::cos(link.alpha);
  const Eigen::Matrix3d rest =
      Eigen::AngleAxisd(-link.alpha, Eigen::Vector3d::UnitX()) * turned * pose.rotation;
  link.theta = std::atan2(rest(1, 0), rest(0, 0));
  return result;
}

}  // namespace

PartToFoot part_to_foot(const KinematicChain& positioner, const Pose& base_of_arm) {
  PartToFoot result;
  result.base = inverse(positioner.tool);
  double alpha = 0, d = 0;  // of the axis that the next one carries
  for (auto link = positioner.links.rbegin(); link != positioner.links.rend(); ++link) {
    if (link->beta != 0)
      throw std::invalid_argument("link '" + link->name +
                                  "' of a positioner has beta_deg; leave it out");
    Link& back = result.links.emplace_back(*link);
    back.alpha = -alpha;
    back.d = -d;
    back.theta = -link->theta;
    back.r = -link->r;
    back.sign = -link->sign;
    alpha = link->alpha;
    d = link->d;
  }
  const Pose before_first{Eigen::AngleAxisd(-alpha, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                          {-d, 0, 0}};
  BehindJoint foot = behind_joint(before_first * inverse(positioner.base) * base_of_arm);
  result.links.back().theta += foot.turn;
  result.links.back().r += foot.shift;
  foot.link.name = "foot";
  result.links.push_back(std::move(foot.link));
  return result;
}

}  // namespace armtrue
