#pragma once

#include <Eigen/Core>
#include <array>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {

/// d(pose)/d(parameter): rows 0-2 the translation [m], rows 3-5 the rotation [rad], both in the
/// axes of R_A; the rotation is the left perturbation, R <- exp(dr) R. Columns by parameter index.
using PoseJacobian = Eigen::Matrix<double, 6, kGeometricParameters>;

/// What each geometric parameter differs by, in one context, from its constant [m, rad].
using ParameterOffsets = Eigen::Matrix<double, kGeometricParameters, 1>;

/// Forward kinematics of one chain for many poses: the trigonometry of the constant angles is done
/// once, here. Every call makes one pass over the chain and takes nothing from the heap.
class ChainEvaluator {
 public:
  explicit ChainEvaluator(const KinematicChain& chain);

  /// R_A from the measured frame.
  Pose pose(const JointVector& q) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets) const;

  /// The same, with the derivative with respect to every geometric parameter.
  Pose pose(const JointVector& q, PoseJacobian& jacobian) const;
  Pose pose(const JointVector& q, const ParameterOffsets& offsets, PoseJacobian& jacobian) const;

  /// R_0 from R_1 ... R_7.
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

/// Moves the translation rows of a Jacobian from the origin of the measured frame to a point
/// rigidly joined to it; `lever` is the point minus that origin, in the axes of R_A [m].
void move_to_point(PoseJacobian& jacobian, const Eigen::Vector3d& lever);

}  // namespace armtrue
