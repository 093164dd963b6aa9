#pragma once

#include <array>
#include <limits>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {

/// Robot programs are read for arms with six revolute axes only.
inline constexpr int kProgramAxes = 6;

/// What a Cartesian target states about the joint angles at which the controller reaches it, in a
/// form common to all makers: KUKA's status and turn, ABB's confdata, FANUC's configuration string.
struct Configuration {
  /// A posture that defines the sides of shoulder, elbow and wrist [rad].
  JointVector reference = JointVector::Zero(kProgramAxes);
  /// Of shoulder, elbow, wrist: 1 the side of the reference, -1 the other, 0 either.
  std::array<int, 3> sides{0, 0, 0};
  /// Range of each joint angle [rad].
  JointVector low = JointVector::Constant(kProgramAxes, -std::numeric_limits<double>::infinity());
  JointVector high = JointVector::Constant(kProgramAxes, std::numeric_limits<double>::infinity());
  /// True for a straight or circular move: the arm stays on its branch, whatever the target states.
  bool continues = false;
  /// True for a straight or circular move from an unknown place: its controller ignores the
  /// configuration, so it counts only if some posture has it.
  bool is_weak = false;
  /// If true, the sides are ignored if no posture in the ranges has them.
  bool sides_are_weak = false;

  bool is_stated() const {
    return sides != std::array<int, 3>{0, 0, 0} || low.array().isFinite().any() ||
           high.array().isFinite().any();
  }
};

/// The pose of a target is rounded: a joint may lie beside its range by so much.
inline constexpr double kRangeSlack = 0.02 * kDegree;

/// How far a joint stands beyond a range [rad]; below zero in it.
double beyond(double low, double high, double q);

/// Whether a posture lies in the ranges of the configuration, to kRangeSlack.
bool is_in_ranges(const Configuration& configuration, const JointVector& q);

}  // namespace armtrue
