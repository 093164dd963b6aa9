#pragma once

#include <array>
#include <optional>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "armtrue/programs/configuration.h"

namespace armtrue {

/// Where the axes of a robot program, A1 to A6 and E1 to E6, stand among the joints of a chain.
struct ProgramJoints {
  std::array<int, kProgramAxes> arm{};  ///< -1: the arm has no such axis, and its number stays
  /// Of an axis that slides: what its joint moves for each rad of the program, which has mm in the
  /// place of deg [m/rad]; else 1.
  std::array<double, kProgramAxes> per_angle{1, 1, 1, 1, 1, 1};
  int first_link = 0;  ///< of axis 1
  int passive = -1;    ///< the axis that the rods of an arm without it move; -1: none
  struct External {
    int joint = -1;  ///< -1: the chain has no such axis
    double si = 1;   ///< [m] or [rad] of the unit of the program, mm or deg
  };
  std::array<External, 6> external{};
  /// Coupling of axis 3 to axis 2 in the chain that the angles of the program contain already, as
  /// FANUC's do (program_values.h) [rad/rad]; mostly 0.
  double third_by_second = 0;

  bool has_external() const;
  /// Whether the arm has all six axes.
  bool is_six() const;
  /// Number of all joints.
  int count() const;
  /// The angles of the arm alone; of axes that it lacks, `otherwise`.
  JointVector arm_of(const JointVector& q,
                     JointVector otherwise = JointVector::Zero(kProgramAxes)) const;
  /// All joints: those of the arm, and the external axes of `other`.
  JointVector whole(const JointVector& arm_joints, const JointVector& other) const;
  /// Moves the external axes of `to` towards those of `from` by the share t.
  void move_external(JointVector& to, const JointVector& from, double t = 1) const;
  /// E1 to E6 at `q` in the units of the program; for those that the chain lacks, `otherwise`.
  std::vector<double> external_numbers(const JointVector& q, std::vector<double> otherwise) const;
};

/// Of six revolute joints that follow one another, beside external axes, or of fewer joints whose
/// links have the numbers of their axes at the end of their names: A1, A2, A3 and A6 of a
/// palletiser. Nothing of any other chain. `from_upper_arm`: whether the angles of axis 3 count
/// from the upper arm, whatever the encoder of the chain does.
std::optional<ProgramJoints> program_joints(const KinematicChain& chain,
                                            bool from_upper_arm = false);

}  // namespace armtrue
