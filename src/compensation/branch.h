#pragma once

#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// Which of the solutions of the inverse kinematics a posture is: the signs of what is zero where
/// two of them meet. 0: so near that it is both, or an arm whose branches have no such names: any
/// but six revolute joints.
struct Branch {
  int shoulder = 0;  ///< wrist before or behind axis 1
  int elbow = 0;     ///< axes 2, 3 and wrist: bent up or down
  int wrist = 0;     ///< axes 4 and 6: bent to one side or the other
};

Branch branch_of(const ChainEvaluator& arm, const JointVector& q);

/// Whether no sign differs; 0 fits both.
bool is_same(const Branch& a, const Branch& b);

/// Whether a posture stays on the branch that it had: only where that was both it may be either.
bool stays(const Branch& before, const Branch& now);

/// Sine of the angle between the axes 4 and 6: 0 where the wrist is stretched and singular. 1 of an
/// arm that is not of six revolute joints.
double wrist_sine(const ChainEvaluator& arm, const JointVector& q);

}  // namespace armtrue
