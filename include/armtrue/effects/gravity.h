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
/// Without masses the load is a basis that spans the torque of any distribution of mass in the
/// carrying links: the first moments of link j itself and of the links after it whose axes stay
/// parallel to joint j (for A2 the sine and cosine of the arm's and of the forearm's angle), per
/// kg m; of a link that slides also the moment by its travel, per kg. Wrist links are left out:
/// their torque is small and would add coefficients. The basis of a joint that slides is empty. The
/// three turns of the base share one basis, which does not depend on the place of R_A. The values
/// are 0 for a turn on which gravity does no work, such as rz of an upright arm.
///
/// Links that follow the joint of a parameter (Coupling) move with it: the last link of a
/// parallelogram keeps its orientation, so its torque does not depend on its centre of mass.
///
/// A positioner (Robot::ground_link) carries the part, which no file knows: its loads are always a
/// basis, the first moments of all frames before the joint in the chain. Gravity keeps its
/// direction in the frame of that link, and turns in R_0.
class GravityLoad {
 public:
  GravityLoad(const Robot& robot, int parameter);

  /// 1 with masses. Otherwise the size of the basis: 0 if gravity does no work on the parameter; of
  /// a parameter of the base, if it does none on any of the three turns.
  int value_count() const;
  /// Whether the masses of the robot make the load, and not a basis.
  bool is_by_masses() const { return by_masses_; }
  /// Writes value_count() values to `out` [N m or N; of a basis per kg m or kg].
  void values(const Context& context, const ArmFrames& frames, double* out) const;

 private:
  struct FirstMoment {
    int link, axis;          // link -1: R_0
    bool by_travel = false;  // times the travel of the link along its z axis
  };
  struct Motion;  // motion by the parameter: its axis, a point on it, and whether it is a rotation
  // A link that follows the joint of the parameter, by `factor` of its motion.
  struct Follower {
    int link;
    double factor;
    bool turns;
  };
  Motion motion(const ArmFrames& frames) const;
  Eigen::Vector3d velocity(const Motion& moved, const ArmFrames& frames, int link,
                           const Eigen::Vector3d& point) const;
  double arm_of(const FirstMoment& moment, const ArmFrames& frames) const;
  std::vector<Motion> motions_of_basis(const ArmFrames& frames) const;
  double first_moment_value(const FirstMoment& moment, const Motion& moved,
                            const ArmFrames& frames) const;
  Eigen::Vector3d gravity_in_foot(const ArmFrames& frames) const;
  std::vector<int> carrying_links(const KinematicChain& chain) const;
  std::vector<int> carried_links() const;
  void choose_basis(const Robot& robot, const ChainEvaluator& evaluator);

  int parameter_;
  int links_;  // number of the links
  int link_;   // first link that moves with the parameter; links_ for the tool
  std::vector<Follower> followers_;
  Eigen::Matrix3d base_rotation_;
  std::array<double, kMaxLinks> beta_{};
  Eigen::Vector3d gravity_;  // in R_0 or the frame of ground_
  int ground_;               // -1: R_0
  bool of_positioner_, by_masses_;
  Eigen::Vector3d payload_point_;  // in R_n
  std::vector<Body> bodies_;
  std::vector<FirstMoment> basis_;
  bool has_work_ = false;  // whether gravity does work on this parameter by the basis
};

}  // namespace armtrue
