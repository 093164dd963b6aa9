#include "armtrue/compensation/program_joints.h"

#include <algorithm>
#include <utility>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr int kNone = -1;

// The number at the end of a name, as of A6 or joint_3; 0: none, or no axis of a program.
int axis_in(const std::string& name) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (name.empty() || !is_digit(name.back())) return 0;
  if (name.size() > 1 && is_digit(name[name.size() - 2])) return 0;
  const int axis = name.back() - '0';
  return axis <= kProgramAxes ? axis : 0;
}

// Six that turn and follow one another count in their order.
bool are_six(const KinematicChain& chain, const std::vector<int>& joints) {
  if (joints.size() != kProgramAxes) return false;
  for (size_t j = 0; j < joints.size(); ++j)
    if (is_prismatic(joint_link(chain, joints[j])) ||
        link_of_joint(chain, joints[j]) != link_of_joint(chain, joints[0]) + static_cast<int>(j))
      return false;
  return true;
}

// The axis of each joint, counted from 0; nothing if their names do not tell them.
std::optional<std::vector<int>> axes_of(const KinematicChain& chain,
                                        const std::vector<int>& joints) {
  std::vector<int> axes;
  const bool in_order = are_six(chain, joints);
  for (const int joint : joints) {
    const int axis =
        in_order ? static_cast<int>(axes.size()) : axis_in(joint_link(chain, joint).name) - 1;
    if (axis < 0 || (!axes.empty() && axis <= axes.back())) return std::nullopt;
    axes.push_back(axis);
  }
  if (axes.empty() || (!in_order && axes.size() == kProgramAxes)) return std::nullopt;
  return axes;
}

}  // namespace

bool ProgramJoints::has_external() const {
  return std::ranges::any_of(external, [](const External& axis) { return axis.joint >= 0; });
}

bool ProgramJoints::is_six() const { return std::ranges::count(arm, kNone) == 0; }

int ProgramJoints::count() const {
  return static_cast<int>(
      kProgramAxes - std::ranges::count(arm, kNone) +
      std::ranges::count_if(external, [](const External& axis) { return axis.joint >= 0; }));
}

JointVector ProgramJoints::arm_of(const JointVector& q, JointVector otherwise) const {
  JointVector angles = std::move(otherwise);
  for (int j = 0; j < kProgramAxes; ++j)
    if (arm[j] >= 0) angles[j] = q[arm[j]] / per_angle[j];
  if (third_by_second != 0) angles[2] += third_by_second * angles[1];
  return angles;
}

JointVector ProgramJoints::whole(const JointVector& arm_joints, const JointVector& other) const {
  JointVector q = other;
  for (int j = 0; j < kProgramAxes; ++j)
    if (arm[j] >= 0) q[arm[j]] = arm_joints[j] * per_angle[j];
  if (third_by_second != 0) q[arm[2]] -= third_by_second * arm_joints[1];
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
  std::vector<int> of_arm;
  int joint = 0;
  for (const JointName& name : joint_names(chain)) {
    if (name.is_external())
      joints.external[name.column[1] - '1'] = {joint, name.si()};
    else
      of_arm.push_back(joint);
    ++joint;
  }
  const auto axes = axes_of(chain, of_arm);
  if (!axes) return std::nullopt;
  joints.arm.fill(kNone);
  joints.first_link = link_of_joint(chain, of_arm[0]);
  for (size_t k = 0; k < of_arm.size(); ++k) {
    joints.arm[(*axes)[k]] = of_arm[k];
    if (is_prismatic(joint_link(chain, of_arm[k])))
      joints.per_angle[(*axes)[k]] = kMillimetre / kDegree;
  }
  constexpr int kBend = 4;  // axis 5
  if (joints.arm[kBend] == kNone &&
      std::ranges::any_of(chain.links, [](const Link& link) { return !link.has_encoder; }))
    joints.passive = kBend;
  if (!from_upper_arm || joints.arm[1] < 0 || joints.arm[2] < 0) return joints;
  for (const Coupling& coupling : chain.couplings)
    if (coupling.follower == link_of_joint(chain, joints.arm[2]) &&
        coupling.followed == link_of_joint(chain, joints.arm[1]))
      joints.third_by_second = coupling.coefficient;
  return joints;
}

}  // namespace armtrue
