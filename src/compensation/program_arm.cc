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

}  // namespace

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
  throw std::invalid_argument("which axes of a program the joints of the arm are is not known");
}

Branch ProgramArm::branch_at(const JointVector& q) const {
  if (!program_joints_) return {};
  if (program_joints_->is_six()) return branch_of(chain(), q, program_joints_->first_link);
  std::array<int, 3> links{};
  for (size_t j = 0; j < links.size(); ++j) {
    if (program_joints_->arm[j] < 0) return {};
    links[j] = link_of_joint(robot_.chain, program_joints_->arm[j]);
  }
  return branch_of_few(robot_.chain, chain(), q, links);
}

double ProgramArm::wrist_sine_at(const JointVector& q) const {
  if (!program_joints_ || !program_joints_->is_six()) return 1;
  return wrist_sine(chain(), q, program_joints_->first_link);
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
