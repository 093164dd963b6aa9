#include "urdf_kinematics.h"

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/tree.hpp>
#include <numbers>
#include <stdexcept>

namespace oracle {
namespace {

KDL::Rotation rounded_to_right_angles(const KDL::Rotation& rotation) {
  KDL::Rotation result;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      result(row, column) = std::round(rotation(row, column));
      if (std::abs(result(row, column) - rotation(row, column)) > 1e-3) return rotation;
    }
  return result;
}

KDL::Segment segment(const urdf::Link& link, RightAngles right_angles) {
  const urdf::Joint& joint = *link.parent_joint;
  const urdf::Pose& origin = joint.parent_to_joint_origin_transform;
  const urdf::Rotation& r = origin.rotation;
  KDL::Frame frame(KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w),
                   KDL::Vector(origin.position.x, origin.position.y, origin.position.z));
  if (right_angles == RightAngles::exact) frame.M = rounded_to_right_angles(frame.M);
  const KDL::Vector axis = frame.M * KDL::Vector(joint.axis.x, joint.axis.y, joint.axis.z);
  KDL::Joint moved(joint.name, KDL::Joint::Fixed);
  if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS)
    moved = KDL::Joint(joint.name, frame.p, axis, KDL::Joint::RotAxis);
  if (joint.type == urdf::Joint::PRISMATIC)
    moved = KDL::Joint(joint.name, frame.p, axis, KDL::Joint::TransAxis);
  return KDL::Segment(link.name, moved, frame);
}

void grow(KDL::Tree& tree, const urdf::Link& link, RightAngles right_angles) {
  for (const auto& child : link.child_links) {
    tree.addSegment(segment(*child, right_angles), link.name);
    grow(tree, *child, right_angles);
  }
}

}  // namespace

UrdfArm::UrdfArm(const std::string& text, const std::string& base, const std::string& tip,
                 RightAngles right_angles) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(text);
  if (!model) throw std::runtime_error("urdfdom does not take the document");
  KDL::Tree tree(model->getRoot()->name);
  grow(tree, *model->getRoot(), right_angles);
  if (!tree.getChain(base, tip, chain_)) throw std::runtime_error("no way from base to tip");
  for (const KDL::Segment& part : chain_.segments) {
    const urdf::Joint& joint = *model->getJoint(part.getJoint().getName());
    UrdfJoint& own = joints_.emplace_back();
    own.name = joint.name;
    own.is_driven = joint.type != urdf::Joint::FIXED;
    const bool is_endless = joint.type == urdf::Joint::CONTINUOUS || !joint.limits;
    own.lower = is_endless ? -std::numbers::pi : joint.limits->lower;
    own.upper = is_endless ? std::numbers::pi : joint.limits->upper;
  }
}

KDL::Frame UrdfArm::pose(const std::vector<double>& q) const {
  KDL::JntArray values(chain_.getNrOfJoints());
  if (q.size() != values.rows()) throw std::runtime_error("not one value for each driven joint");
  for (size_t j = 0; j < q.size(); ++j) values(static_cast<unsigned>(j)) = q[j];
  KDL::Frame result;
  KDL::ChainFkSolverPos_recursive solver(chain_);
  if (solver.JntToCart(values, result) < 0) throw std::runtime_error("KDL finds no pose");
  return result;
}

}  // namespace oracle
