#pragma once

#include <array>
#include <vector>

#include "armtrue/effects/context.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// Frames of the arm in one context: R_0 from R_1 ... R_n.
using ArmFrames = LinkFrames;

/// The generalised force of gravity on a parameter of the chain, Q = g . sum_k m_k
/// d(com_k)/d(parameter) [N m for an angle, N for a length]. For A_j.theta it is the torque of
/// gravity on joint j.
///
/// If the robot has no masses, the load is a basis that spans the torque of any distribution of
/// mass in the carrying links. These are link j and the links after it whose axes stay parallel to
/// joint j. Their first moments are the basis, per kg m (for A2 the sine and cosine of the angle of
/// the arm and of the forearm); a prismatic link adds the part of its travel, per kg. Wrist links
/// are left out: their torque is small and would add coefficients. The basis of a prismatic joint
/// is empty.
class GravityLoad {
 public:
  GravityLoad(const Robot& robot, int parameter);

  /// 1 if the robot has masses. Otherwise the size of the basis: 0 if gravity does no work on the
  /// parameter.
  int value_count() const;
  void values(const Context& context, const ArmFrames& frames, double* out) const;

 private:
  struct FirstMoment {
    int link, axis;
    bool by_travel = false;  // times the travel of the link along its z axis
  };
  struct Motion;  // motion by the parameter: its axis, a point on it, and whether it is a rotation
  Motion motion(const ArmFrames& frames) const;
  double first_moment_value(const FirstMoment& moment, const ArmFrames& frames) const;
  std::vector<int> carrying_links(const KinematicChain& chain) const;
  void choose_basis(const Robot& robot, const ChainEvaluator& evaluator);

  int parameter_;
  int links_;  // number of the links
  int link_;   // first link that moves with the parameter; links_ for the tool
  Eigen::Matrix3d base_rotation_;
  std::array<double, kMaxLinks> beta_{};
  Eigen::Vector3d gravity_;
  Eigen::Vector3d payload_point_;  // in R_n
  std::vector<Body> bodies_;
  std::vector<FirstMoment> basis_;
};

}  // namespace armtrue
