#include "compensation/near_posture.h"

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "compensation/joint_correction.h"

namespace armtrue {
namespace {

constexpr int kForearm = 3;  // axis 4

}  // namespace

NearPosture::NearPosture(const ProgramArm& arm, const JointVector& like, Turns turns)
    : arm_(arm),
      like_(like),
      turns_(turns),
      branch_(arm.branch_at(like)),
      rolls_(arm.chain().is_six_axis_arm() &&
             std::abs(std::sin(arm.robot().chain.links[kForearm].alpha)) > 0.5) {}

std::optional<JointVector> NearPosture::reach(const Context& context, const Pose& wanted,
                                              const JointVector& from) const {
  const JointCorrection found = joints_of_pose(arm_, context, wanted, from);
  if (!found.is_reached || !is_on_branch(found.q)) return std::nullopt;
  return nearer(context, wanted, found.q);
}

// Otherwise, with a tool that hangs down, axes 4 and 6 would turn by half a turn where the forearm
// hangs down.
JointVector NearPosture::nearer(const Context& context, const Pose& wanted,
                                const JointVector& q) const {
  if (!rolls_ || turn_of_forearm(q) <= 0.25 * kTurn) return turned(q);
  JointVector start = q;
  const Link& wrist = arm_.robot().chain.links[kForearm + 1];
  start[kForearm] += 0.5 * kTurn;
  start[kForearm + 1] = -q[kForearm + 1] - 2 * wrist.sign * wrist.theta;
  start[kForearm + 2] += 0.5 * kTurn;
  const JointCorrection other = joints_of_pose(arm_, context, wanted, start);
  const bool is_nearer =
      other.is_reached && is_on_branch(other.q) && turn_of_forearm(other.q) < turn_of_forearm(q);
  return turned(is_nearer ? other.q : q);
}

bool NearPosture::is_on_branch(const JointVector& q) const {
  Branch branch = arm_.branch_at(q);
  if (rolls_) branch.wrist = branch_.wrist;  // nearer() chooses
  return is_same(branch_, branch);
}

double NearPosture::turn_of_forearm(const JointVector& q) const {
  return std::abs(std::remainder(q[kForearm] - like_[kForearm], kTurn));
}

JointVector NearPosture::turned(JointVector q) const {
  const KinematicChain& chain = arm_.robot().chain;
  for (int j = 0; j < joint_count(chain); ++j) {
    const Link& link = joint_link(chain, j);
    if (is_prismatic(link)) continue;
    q[j] = like_[j] + std::remainder(q[j] - like_[j], kTurn);
    if (turns_ == Turns::nearest) continue;
    for (double other : {q[j] - kTurn, q[j] + kTurn})
      if ((q[j] < link.min || q[j] > link.max) && other >= link.min && other <= link.max)
        q[j] = other;
  }
  return q;
}

}  // namespace armtrue
