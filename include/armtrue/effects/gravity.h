#pragma once

#include <array>
#include <vector>

#include "armtrue/effects/context.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// Frames of the arm in one context: R_0 from R_1 ... R_n.
using ArmFrames = LinkFrames;

/// The generalised force of gravity on a parameter of the chain: the work of the weights per unit
/// of the parameter, g . sum_k m_k d(com_k)/d(parameter) [N m for an angle, N for a length]. For
/// A_j.theta it is the torque of gravity on joint j.
///
/// Without masses the load is a basis that spans the torque of any distribution of mass in the
/// carrying links: the first moments of link j itself and of the links after it whose axes stay
/// parallel to joint j (for A2 the sine and cosine of the arm's and of the forearm's angle), per
/// kg m; of a link that slides also what its travel adds, per kg. Wrist links are left out: their
/// torque is small and would add coefficients. The basis of a joint that slides is empty.
class GravityLoad {
 public:
  GravityLoad(const Robot& robot, int parameter);

  /// With masses 1. Without masses the size of the basis: 0 if gravity does no work on the
  /// parameter.
  int value_count() const;
  void values(const Context& context, const ArmFrames& frames, double* out) const;

 private:
  struct FirstMoment {
    int link, axis;
    bool by_travel = false;  // times the way of the link along its z axis
  };
  struct Motion;  // what the parameter moves: an axis, a point of it, and whether it turns
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
