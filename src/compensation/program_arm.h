#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/effects/context.h"
#include "armtrue/effects/robot_model.h"
#include "compensation/branch.h"

namespace armtrue {

using JointJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// An arm from its foot R_0 to the TCP of a program: links and effects of the arm, without base and
/// tool of the measurement. `base` of the robot stays in the model, because effects on it are in
/// the axes of R_A; then its inverse is applied.
class ProgramArm {
 public:
  /// `tool`: the last link's frame from the TCP. Throws std::invalid_argument as RobotModel does.
  ProgramArm(const Robot& robot, const CompensationOptions& options, const Pose& tool,
             const std::vector<std::string>& temperature_names);

  /// R_0 from the TCP. The force of the context is in the axes of R_0.
  Pose pose(const Context& context) const;
  /// Also its derivative by the encoder angles, in the axes of R_0: rows 0-2 m, 3-5 rad, each
  /// per rad or m.
  /// Effects are taken as constant: they change by 1e-2 of an angle at most. Zero by external axes,
  /// unless the options say that they may move.
  Pose pose(const Context& context, JointJacobian& jacobian) const;

  const Robot& robot() const { return robot_; }
  const ChainEvaluator& chain() const { return model_.chain(); }
  /// Joints that stay: the external axes, unless the options say that they may move.
  const std::vector<int>& held() const { return held_; }
  /// Throws std::invalid_argument if program_joints() of the chain is nothing.
  const ProgramJoints& program_joints() const;
  /// Of an arm with fewer than six axes the elbow alone; of one whose axes are not known, or that
  /// has more, without sides.
  Branch branch_at(const JointVector& q) const;
  /// wrist_sine() of an arm with six axes beside external ones; 1 of any other.
  double wrist_sine_at(const JointVector& q) const;

 private:
  Context in_station(Context context) const;

  Robot robot_;
  RobotModel model_;
  Pose foot_from_station_;
  std::vector<int> held_;  // joints
  std::optional<ProgramJoints> program_joints_;
};

/// Difference of the pose `reached` from `wanted`.
PoseDifference difference(const Pose& wanted, const Pose& reached);

}  // namespace armtrue
