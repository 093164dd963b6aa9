#pragma once

#include <array>
#include <limits>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Robot programs are about arms of six revolute axes.
inline constexpr int kProgramAxes = 6;

/// What a Cartesian target says of the joint angles at which the controller reaches it, in the
/// words of no maker: KUKA's status and turn, ABB's confdata, FANUC's configuration string.
struct Configuration {
  /// A posture whose sides of the shoulder, the elbow and the wrist are known [rad].
  JointVector reference = JointVector::Zero(kProgramAxes);
  /// Shoulder, elbow, wrist: 1 the side of the reference, -1 the other, 0 either.
  std::array<int, 3> sides{0, 0, 0};
  /// Where each joint stands [rad].
  JointVector low = JointVector::Constant(kProgramAxes, -std::numeric_limits<double>::infinity());
  JointVector high = JointVector::Constant(kProgramAxes, std::numeric_limits<double>::infinity());
  /// A straight or circular move: the arm stays on the branch on which it is, whatever is stated.
  bool continues = false;
  /// The sides are dropped if no posture in the ranges has them.
  bool sides_are_weak = false;

  bool is_stated() const {
    return sides != std::array<int, 3>{0, 0, 0} || low.array().isFinite().any() ||
           high.array().isFinite().any();
  }
};

/// Whether a posture stands in the ranges of the configuration, within 0.02 deg.
bool is_in_ranges(const Configuration& configuration, const JointVector& q);

}  // namespace armtrue
