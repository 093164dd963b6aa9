#include "compensation/programmed_joints.h"

#include <fmt/format.h>

#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/units.h"
#include "compensation/branch.h"
#include "compensation/joint_correction.h"

namespace armtrue {
bool follows_motion(const Effect& effect) {
  return effect.driver.involves(DriverKind::arrival) || effect.driver.involves(DriverKind::stroke);
}

bool follows_motion(const Robot& robot) {
  for (const Effect& effect : robot.effects)
    if (follows_motion(effect)) return true;
  return false;
}

void require_context(const Robot& robot, const Campaign& visits, bool tool_is_measured) {
  for (const Effect& effect : robot.effects) {
    const bool from_sequence = follows_motion(effect) && visits.arrival.empty();
    if (moves_program(effect, tool_is_measured) && !from_sequence &&
        !effect.driver.involves(DriverKind::motor_torque))
      require_drivers(visits, effect);
  }
}

Arrival CommandedMotion::behind(std::span<const JointVector> way) const {
  Arrival next = last_.value_or(Arrival(way.back()));
  for (const JointVector& q : way) next.go_to(q);
  return next;
}

void CommandedMotion::arrive(Context& context, std::span<const JointVector> way) const {
  const Arrival next = behind(way);
  if (!states_arrival_) context.arrival = next.direction();
  if (!states_stroke_) context.stroke = next.stroke();
}

FoundJoints joints_on_branch(const ProgramArm& arm, const Context& context, const Pose& wanted,
                             const JointVector& hint, int more_starts) {
  const Branch branch = arm.branch_at(hint);
  JointCorrection found = joints_of_pose(arm, context, wanted, hint);
  if (found.is_reached && is_same(branch, arm.branch_at(found.q))) return {found.q, Reach::reached};
  // A singular posture may lie between the hint and the solution: start beside the hint, in a fixed
  // order.
  bool is_reached = found.is_reached;
  for (int k = 1; k <= more_starts; ++k) {
    JointVector start = hint;
    for (int j = 0; j < static_cast<int>(start.size()); ++j)
      start[j] += 0.8 * (1 - 2 * share_of_start(k, j));
    for (int joint : arm.held()) start[joint] = hint[joint];
    found = joints_of_pose(arm, context, wanted, start);
    is_reached |= found.is_reached;
    if (!found.is_reached || (found.q - hint).cwiseAbs().maxCoeff() > kTurn) continue;
    if (is_same(branch, arm.branch_at(found.q))) return {found.q, Reach::reached};
  }
  return {found.q, is_reached ? Reach::on_another_branch : Reach::unreachable};
}

JointVector ProgrammedJoints::hint(int row, const std::optional<JointVector>& previous) const {
  const size_t r = row;
  if (!program_.is_cartesian(r) || program_.hinted[r]) return program_.visits.q[r];
  if (previous) return with_external(row, *previous);
  if (!options_.start) throw UnreachableTarget(row, why_no_hint());
  return with_external(row, *options_.start);
}

std::string ProgrammedJoints::why_no_hint() const {
  return "nothing says on which branch the first target lies; " +
         (is_text() ? std::string("give --start, joint angles near it")
                    : "add columns " + encoder_columns(controller_.robot().chain) +
                          " with joint angles near it, or --start");
}

JointVector ProgrammedJoints::with_external(int row, JointVector q) const {
  if (program_.states_external)
    controller_.program_joints().move_external(q, program_.visits.q[row]);
  return q;
}

JointVector ProgrammedJoints::at(int row, const Context& context, const JointVector& hint,
                                 int more_starts) const {
  if (!program_.is_cartesian(row)) {
    check_turn(row, hint);
    return hint;
  }
  const Pose wanted = options_.base * program_.poses[row];
  const FoundJoints found = joints_on_branch(controller_, context, wanted, hint, more_starts);
  if (found.reach == Reach::on_another_branch)
    throw OutOfReach(
        row, "the controller's model reaches it only on another branch than that of " +
                 (is_text() ? std::string("the target before it, or of its qnear; check "
                                          "the frames and the tool")
                            : "its hint; correct " + encoder_columns(controller_.robot().chain) +
                                  ", or add them"));
  if (found.reach == Reach::unreachable)
    throw OutOfReach(row,
                     "the controller's model does not reach it; check its unit and frame, --base "
                     "and --tool");
  return in_turn(row, found.q);
}

void ProgrammedJoints::check_turn(int row, const JointVector& q) const {
  if (program_.turns.empty()) return;
  const int turn = program_.turns[row];
  for (int j = 0; j < kProgramAxes; ++j) {
    const bool below = (turn >> j) & 1;
    if ((q[j] < 0) != below)
      throw UnreachableTarget(
          row, fmt::format("its turn t = {} says that {} stands {} zero, and it stands at {:.6g} "
                           "deg; correct t, or rename the column if it is another",
                           turn, joint_link(controller_.robot().chain, j).name,
                           below ? "below" : "above", q[j] / kDegree));
  }
}

// The same posture with the turns that the target states.
JointVector ProgrammedJoints::in_turn(int row, JointVector q) const {
  if (program_.turns.empty()) return q;
  const KinematicChain& chain = controller_.robot().chain;
  for (int j = 0; j < kProgramAxes; ++j) {
    const bool below = (program_.turns[row] >> j) & 1;
    if ((q[j] < 0) == below) continue;
    q[j] += below ? -kTurn : kTurn;
    const Link& link = joint_link(chain, j);
    if (q[j] < link.min || q[j] > link.max || (q[j] < 0) != below)
      throw UnreachableTarget(
          row, fmt::format("its turn says that {} stands {} zero, where it cannot; correct t",
                           link.name, below ? "below" : "above"));
  }
  return q;
}

}  // namespace armtrue
