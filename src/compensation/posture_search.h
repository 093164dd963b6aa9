#pragma once

#include <optional>

#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/configuration.h"
#include "compensation/branch.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Looks for the joint angles at which an arm of up to six axes, perhaps with external ones that
/// stay, has a pose in a stated configuration: from the posture before, from the reference of the
/// configuration, then among all postures if they are known, else from other starts in a fixed
/// order. One within the travel is preferred.
class PostureSearch {
 public:
  /// `wanted`: R_0 from TCP. `context`: its q holds the external axes, if there are some. The
  /// arguments must live as long as the search. Throws std::invalid_argument as
  /// ProgramArm::program_joints() does.
  PostureSearch(const ProgramArm& arm, const Context& context, const Pose& wanted,
                const Configuration& stated, const std::optional<JointVector>& before);

  /// The joint angles [rad]; nothing if no start leads to any in the configuration.
  std::optional<JointVector> find() const { return found_; }
  /// Whether the arm reaches the pose at all.
  bool is_reached() const { return is_reached_; }
  /// Whether an arm of fewer than six axes has the pose with its elbow on either side, so that
  /// which one its controller takes is not known.
  bool is_one_of_several() const { return is_one_of_several_; }

 private:
  void try_from(const JointVector& start);
  JointVector start(int k) const;  // the k-th one, in a fixed order
  void look_for_another();
  double lowest(int axis) const { return stated_.low[axis] * joints_.per_angle[axis]; }
  double highest(int axis) const { return stated_.high[axis] * joints_.per_angle[axis]; }
  void take(const JointVector& solution);
  bool look_at_all();  // whether all_postures() settles it
  /// The same posture, turned so that each joint stands in its range and, if asked for, in its
  /// travel; nothing if that cannot be.
  std::optional<JointVector> in_ranges(JointVector q, bool in_travel) const;
  bool has_sides(const JointVector& q) const;
  int joint(int axis) const { return joints_.arm[axis]; }

  const ProgramArm& arm_;
  const ProgramJoints joints_;
  const Context& context_;
  const Pose& wanted_;
  const Configuration& stated_;
  const std::optional<JointVector>& before_;
  Branch reference_;
  bool is_reached_ = false;
  bool is_one_of_several_ = false;
  std::optional<JointVector> found_;
  std::optional<JointVector> in_ranges_only_;  // on other sides
  std::optional<JointVector> beyond_travel_;   // reported later by the note `limit`
};

}  // namespace armtrue
