#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "armtrue/effects/context.h"
#include "armtrue/effects/gravity.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// An effect resolved for one robot: the parameters that its coefficients move, and the values that
/// multiply the coefficients. Drivers and torques are computed with the chain at construction. A
/// later calibration changes lengths, and so these values, by about 1e-3 of themselves.
class BoundEffect {
 public:
  /// offset[parameter] += coefficient * value
  struct Term {
    int parameter, coefficient, value;
  };

  /// Throws std::invalid_argument if the robot or the campaign lacks what the effect names.
  BoundEffect(const Effect& effect, const Robot& robot,
              const std::vector<std::string>& temperature_names = {});

  int coefficient_count() const { return coefficient_count_; }
  int value_count() const { return value_count_; }
  const std::vector<Term>& terms() const { return terms_; }
  /// The parameters moved, each once.
  const std::vector<int>& parameters() const { return parameters_; }
  const std::vector<std::string>& coefficient_names() const { return coefficient_names_; }
  bool needs_frames() const { return needs_frames_; }
  bool needs_jacobian() const { return needs_jacobian_; }

  /// Writes value_count() values to `out`. `frames` is read if needs_frames(); `jacobian`, at the
  /// context's pose, if needs_jacobian().
  void values(const Context& context, const ArmFrames* frames, const PoseJacobian* jacobian,
              double* out) const;

 private:
  void bind_members(const Effect& effect, const Robot& robot,
                    const std::vector<std::string>& temperature_names);
  int bind_loads(const Effect& effect, const Robot& robot);
  void set_terms(int load_values);
  // All members of a group share the torque on a joint.
  const GravityLoad& load_on(size_t member) const {
    return loads_[std::min(member, loads_.size() - 1)];
  }
  double driver_value(DriverKind kind, int joint, size_t member, const Context& context,
                      const ArmFrames* frames, const PoseJacobian* jacobian) const;
  double factor_value(size_t member, const Context& context, const ArmFrames* frames,
                      const PoseJacobian* jacobian) const;
  double sight_value(DriverKind kind, const Pose& measured) const;
  void shape_values(size_t member, const Context& context, const ArmFrames* frames,
                    const PoseJacobian* jacobian, double* out) const;

  Driver driver_;
  Shape shape_;
  std::optional<std::array<double, 2>> measured_;  // see Effect
  Pose base_, tool_;
  Eigen::Vector3d instrument_, up_;
  Eigen::Vector3d gravity_;  // unit vector, in the ground
  int ground_ = -1;          // link that is the ground, -1: R_0
  int temperature_ = -1;
  std::vector<GravityLoad> loads_;
  std::vector<int> parameters_;
  std::vector<double> factors_;  // of the value, for each parameter; empty: 1
  std::vector<Term> terms_;
  std::vector<std::string> coefficient_names_;
  int coefficient_count_ = 0, value_count_ = 0;
  bool own_values_ = false;  // of each parameter
  bool needs_frames_ = false, needs_jacobian_ = false;
  std::vector<BoundEffect> members_;  // of a whole family
};

/// Predicts poses: the chain, with the effects that the robot file declares. The constructor throws
/// std::invalid_argument as BoundEffect, for an effect that the motor torque drives, which is only
/// known where it was measured, and for an effect with another number of coefficients than its
/// form needs.
class RobotModel {
 public:
  explicit RobotModel(const Robot& robot, const std::vector<std::string>& temperature_names = {});

  /// The reading of the measured frame: R_A_from_measured, with the effects and the errors of the
  /// instrument.
  Pose pose(const Context& context) const;

  /// The same for a target, an index into the chain's targets, or -1 for the measured frame's
  /// origin.
  Eigen::Vector3d point(const Context& context, int target) const;

  /// The reading of the target's distance from an anchor, an index into the chain's anchors:
  /// scale |p - a| + zero.
  double distance(const Context& context, int target, int anchor) const;

  const ChainEvaluator& chain() const { return chain_; }

  /// The sum of all effects on each parameter of the chain, the instrument, targets and anchors.
  Eigen::VectorXd offsets(const Context& context) const;

 private:
  Eigen::Vector3d place(const Context& context, int target, const Eigen::VectorXd& offsets) const;
  Eigen::Vector3d read(const Eigen::Vector3d& point, const Eigen::VectorXd& offsets) const;

  ChainEvaluator chain_;
  std::vector<Target> targets_;
  std::vector<Anchor> anchors_;
  Eigen::Vector3d instrument_, up_;
  ParameterLayout layout_;
  int parameters_;
  std::vector<BoundEffect> effects_;
  std::vector<std::vector<double>> coefficients_;
};

}  // namespace armtrue
