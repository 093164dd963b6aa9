#pragma once

#include <Eigen/Core>
#include <array>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// Derivative of the pose with respect to each geometric parameter, in the axes of R_A.
/// Column k belongs to the parameter of index k (see parameters.h).
/// Rows 0-2: derivative of the translation [m per unit of the parameter].
/// Rows 3-5: derivative of the rotation vector dr of the left perturbation R <- exp([dr]x) R
/// [rad per unit of the parameter].
using PoseJacobian = Eigen::Matrix<double, 6, kGeometricParameters>;

/// Difference of each geometric parameter from its constant value for one reading [m, rad].
using ParameterOffsets = Eigen::Matrix<double, kGeometricParameters, 1>;

/// Computes the forward kinematics of one chain for many poses. The constructor computes sine and
/// cosine of the constant angles once. Each call makes one pass over the chain and does not
/// allocate.
class ChainEvaluator {
 public:
  explicit ChainEvaluator(const KinematicChain& chain);

  /// Returns R_A_from_measured; q are encoder angles [rad]. `offsets` are added to the constants.
  Pose pose(const JointVector& q) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets) const;

  /// Returns R_A_from_measured and writes its derivative to `jacobian`.
  Pose pose(const JointVector& q, PoseJacobian& jacobian) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets, PoseJacobian& jacobian) const;

  /// Returns R_0_from_R_j for j = 1 ... 7.
  std::array<Pose, kLinks> link_frames(const JointVector& q) const;

 private:
  struct Trigonometry {
    double cos_alpha, sin_alpha, cos_beta, sin_beta;
    double alpha, d, theta, r, beta, sign;
  };
  template <bool kWithOffsets, bool kWithJacobian>
  Pose evaluate(const JointVector& q, const ParameterOffsets* offsets,
                PoseJacobian* jacobian) const;

  Pose base_, tool_;
  std::array<Trigonometry, kLinks> links_;
};

/// Moves the translation rows from the origin of the measured frame to a point fixed in that frame:
///     J_t <- J_t - [lever]x J_r,    i.e. dp = dt + dr x lever.
/// J_t: rows 0-2, J_r: rows 3-5. `lever`: point minus origin, in the axes of R_A [m].
void move_to_point(PoseJacobian& jacobian, const Eigen::Vector3d& lever);

}  // namespace armtrue
