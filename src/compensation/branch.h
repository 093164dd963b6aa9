#pragma once

#include <array>

#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// The branch of a posture among the solutions of the inverse kinematics, as three signs. Each is
/// the sign of a quantity that is zero where two branches meet. 0: so near zero that both count, or
/// the arm has no such branches.
struct Branch {
  int shoulder = 0;  ///< wrist before or behind axis 1
  int elbow = 0;     ///< axes 2, 3 and wrist: bent up or down
  int wrist = 0;     ///< axes 4 and 6: bent to one side or the other
};

/// Branch of the six revolute links from `first` on.
Branch branch_of(const ChainEvaluator& arm, const JointVector& q, int first);

/// Branch of an arm of three to five axes: the side of its elbow alone. Where axes 1 to 3, on these
/// links, move the place of the link behind them in two directions only, two branches meet.
Branch branch_of_few(const KinematicChain& chain, const ChainEvaluator& arm, const JointVector& q,
                     const std::array<int, 3>& links);

/// Whether no sign differs; 0 equals both signs.
bool is_same(const Branch& a, const Branch& b);

/// Whether a posture stays on its previous branch. A sign that was 0 may become either.
bool stays(const Branch& before, const Branch& now);

/// Sine of the angle between axes 4 and 6 of these links: 0 if the wrist is stretched and singular.
double wrist_sine(const ChainEvaluator& arm, const JointVector& q, int first);

}  // namespace armtrue
