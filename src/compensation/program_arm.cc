#include "compensation/program_arm.h"

#include <algorithm>
#include <stdexcept>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

Robot with_tool(Robot robot, const Pose& tool) {
  robot.chain.tool = tool;
  return robot;
}

std::vector<int> external_axes(const KinematicChain& chain) {
  std::vector<int> external;
  int joint = 0;
  for (const JointName& name : joint_names(chain)) {
    if (name.is_external()) external.push_back(joint);
    ++joint;
  }
  return external;
}

// Posture and loads act on the foot of the arm; a clock and a thermometer do not tell whose drift
// it is.
bool is_of_the_arm(DriverKind kind) {
  switch (kind) {
    case DriverKind::joint_angle:
    case DriverKind::gravity_torque:
    case DriverKind::motor_torque:
    case DriverKind::arrival:
    case DriverKind::stroke:
    case DriverKind::payload:
    case DriverKind::force:
    case DriverKind::moment:
    case DriverKind::tool_weight:
    case DriverKind::gravity_direction:
      return true;
    case DriverKind::time:
    case DriverKind::session:
    case DriverKind::temperature:
    case DriverKind::position:
    case DriverKind::range:
    case DriverKind::azimuth:
    case DriverKind::elevation:
    case DriverKind::incidence:
    case DriverKind::place:
      break;
  }
  return false;
}

}  // namespace

bool moves_program(const Effect& effect, bool tool_is_measured) {
  if (effect.may_be_instrument) return false;
  switch (owner_of(effect)) {
    case Owner::instrument:
    case Owner::target:
    case Owner::anchor:
    case Owner::board:
    case Owner::camera:
    case Owner::contact:
      return false;
    case Owner::tool:
      return tool_is_measured;
    case Owner::base:
      return is_of_the_arm(effect.driver.kind) ||
             (effect.driver.factor && is_of_the_arm(*effect.driver.factor));
    case Owner::link:
    case Owner::coupling:
    case Owner::several:
      break;
  }
  return true;
}

Robot without_station_effects(Robot robot, bool tool_is_measured) {
  for (const Effect& effect : robot.effects)
    if (effect.mean != 0)
      if (const auto parameter = find_parameter(robot.chain, effect.parameter))
        move_parameter(robot.chain, *parameter, effect.mean);
  std::erase_if(robot.effects,
                [&](const Effect& effect) { return !moves_program(effect, tool_is_measured); });
  return robot;
}

ProgramArm::ProgramArm(const Robot& robot, const CompensationOptions& options, const Pose& tool,
                       const std::vector<std::string>& temperature_names)
    : robot_(with_tool(without_station_effects(robot, options.tool_is_measured), tool)),
      model_(robot_, temperature_names),
      foot_from_station_(inverse(robot.chain.base)),
      program_joints_(armtrue::program_joints(robot.chain)) {
  if (!options.move_external_axes) held_ = external_axes(robot_.chain);
}

const ProgramJoints& ProgramArm::program_joints() const {
  if (program_joints_) return *program_joints_;
  throw std::invalid_argument("the arm has not six axes beside external ones");
}

Branch ProgramArm::branch_at(const JointVector& q) const {
  return program_joints_ ? branch_of(chain(), q, program_joints_->first_link) : Branch{};
}

double ProgramArm::wrist_sine_at(const JointVector& q) const {
  return program_joints_ ? wrist_sine(chain(), q, program_joints_->first_link) : 1.0;
}

Context ProgramArm::in_station(Context context) const {
  context.force_n = robot_.chain.base.rotation * context.force_n;
  return context;
}

Pose ProgramArm::pose(const Context& context) const {
  return foot_from_station_ * model_.pose(in_station(context));
}

Pose ProgramArm::pose(const Context& context, JointJacobian& jacobian) const {
  const ParameterOffsets offsets =
      model_.offsets(in_station(context)).head(layout_of(robot_.chain).geometric);
  PoseJacobian all;
  const Pose pose = foot_from_station_ * model_.chain().pose(context.q, offsets, all);
  jacobian.resize(Eigen::NoChange, joint_count(robot_.chain));
  for (int j = 0; j < static_cast<int>(jacobian.cols()); ++j) {
    const Eigen::Matrix<double, 6, 1> column = joint_column(robot_.chain, all, j);
    jacobian.col(j).head<3>() = foot_from_station_.rotation * column.head<3>();
    jacobian.col(j).tail<3>() = foot_from_station_.rotation * column.tail<3>();
  }
  for (int joint : held_) jacobian.col(joint).setZero();
  return pose;
}

PoseDifference difference(const Pose& wanted, const Pose& reached) {
  return {(wanted.translation - reached.translation).norm(),
          rotation_log(wanted.rotation * reached.rotation.transpose()).norm()};
}

}  // namespace armtrue
