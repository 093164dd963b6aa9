#pragma once

#include <optional>

#include "compensation/branch.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Finds the posture of an arm that is most like a given one: shoulder and elbow as there, and the
/// nearest whole turns. If axis 4 turns the forearm, that of the two postures of the wrist is taken
/// whose axis 4 is nearer; else the wrist stays on its side.
class NearPosture {
 public:
  enum class Turns { nearest, within_travel };  ///< nearest: even beyond the travel

  /// The arm must outlive it.
  NearPosture(const ProgramArm& arm, const JointVector& like, Turns turns);

  /// Joint angles at which the arm has the pose R_0 from TCP; the search begins at `from`. Nothing
  /// if it ends elsewhere or on another branch.
  std::optional<JointVector> reach(const Context& context, const Pose& wanted,
                                   const JointVector& from) const;

  /// The same from angles `q` that have the pose.
  JointVector nearer(const Context& context, const Pose& wanted, const JointVector& q) const;

 private:
  bool is_on_branch(const JointVector& q) const;
  double turn_of_forearm(const JointVector& q) const;
  JointVector turned(JointVector q) const;

  const ProgramArm& arm_;
  JointVector like_;
  Turns turns_;
  Branch branch_;
  bool rolls_;  // axis 4 is across axis 3 and turns the forearm, as in most arms but a UR
};

}  // namespace armtrue
