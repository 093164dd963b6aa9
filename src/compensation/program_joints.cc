#include "armtrue/compensation/program_joints.h"

#include <algorithm>

#include "armtrue/kinematics/joint_names.h"

namespace armtrue {

int ProgramJoints::count() const {
  return kProgramAxes + static_cast<int>(std::ranges::count_if(
                            external, [](const External& axis) { return axis.joint >= 0; }));
}

JointVector ProgramJoints::arm_of(const JointVector& q) const {
  JointVector angles(kProgramAxes);
  for (int j = 0; j < kProgramAxes; ++j) angles[j] = q[arm[j]];
  angles[2] += third_by_second * angles[1];
  return angles;
}

JointVector ProgramJoints::whole(const JointVector& arm_joints, const JointVector& other) const {
  JointVector q = other;
  for (int j = 0; j < kProgramAxes; ++j) q[arm[j]] = arm_joints[j];
  q[arm[2]] -= third_by_second * arm_joints[1];
  return q;
}

void ProgramJoints::move_external(JointVector& to, const JointVector& from, double t) const {
  for (const External& axis : external)
    if (axis.joint >= 0) to[axis.joint] += t * (from[axis.joint] - to[axis.joint]);
}

std::vector<double> ProgramJoints::external_numbers(const JointVector& q,
                                                    std::vector<double> otherwise) const {
  for (size_t i = 0; i < std::min(external.size(), otherwise.size()); ++i)
    if (external[i].joint >= 0) otherwise[i] = q[external[i].joint] / external[i].si;
  return otherwise;
}

std::optional<ProgramJoints> program_joints(const KinematicChain& chain, bool from_upper_arm) {
  ProgramJoints joints;
  int joint = 0, found = 0;
  for (const JointName& name : joint_names(chain)) {
    if (name.is_external()) {
      joints.external[name.column[1] - '1'] = {joint, name.si()};
    } else {
      const int link = link_of_joint(chain, joint);
      if (found == 0) joints.first_link = link;
      if (found == kProgramAxes || name.is_length || link != joints.first_link + found)
        return std::nullopt;
      joints.arm[found++] = joint;
    }
    ++joint;
  }
  if (found != kProgramAxes) return std::nullopt;
  for (const Coupling& coupling : chain.couplings)
    if (from_upper_arm && coupling.follower == joints.first_link + 2 &&
        coupling.followed == joints.first_link + 1)
      joints.third_by_second = coupling.coefficient;
  return joints;
}

}  // namespace armtrue
