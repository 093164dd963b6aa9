#include "compensation/posture_search.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/units.h"
#include "compensation/all_postures.h"
#include "compensation/joint_correction.h"

namespace armtrue {
namespace {

constexpr int kStarts = 240;

// The multiple of a turn that brings an angle into [low, high], next to `near`; nothing if none
// does. Where one lies beside an end of a whole turn and another within it, that is the one.
std::optional<double> turned_into(double angle, double low, double high, double near) {
  const auto beside = [&](double turned) {
    return high - low > 1.5 * kTurn ? 0 : std::max(0.0, beyond(low, high, turned));
  };
  std::optional<double> best;
  for (int k = -3; k <= 3; ++k) {
    const double turned = angle + k * kTurn;
    if (turned < low - kRangeSlack || turned > high + kRangeSlack) continue;
    if (!best || beside(turned) < beside(*best) ||
        (beside(turned) == beside(*best) && std::abs(turned - near) < std::abs(*best - near)))
      best = turned;
  }
  return best;
}

}  // namespace

PostureSearch::PostureSearch(const ProgramArm& arm, const Context& context, const Pose& wanted,
                             const Configuration& stated, const std::optional<JointVector>& before)
    : arm_(arm),
      joints_(arm.program_joints()),
      context_(context),
      wanted_(wanted),
      stated_(stated),
      before_(before),
      reference_(joints_.is_six() ? arm.branch_at(joints_.whole(stated.reference, context.q))
                                  : Branch{}) {
  if (before) try_from(joints_.whole(joints_.arm_of(*before), context.q));
  if (!found_) try_from(joints_.whole(stated.reference, context.q));
  const bool is_done = found_.has_value() || look_at_all();
  for (int k = 1; k <= kStarts && !found_ && !is_done; ++k) {
    try_from(start(k));
  }
  if (!found_ && stated.sides_are_weak) found_ = in_ranges_only_;
  if (!found_ && !stated.is_weak) found_ = beyond_travel_;
  if (found_ && !joints_.is_six()) look_for_another();
}

JointVector PostureSearch::start(int k) const {
  JointVector q = context_.q;
  for (int j = 0; j < kProgramAxes; ++j) {
    if (joint(j) < 0) continue;
    const auto [min, max] = travel(joint_link(arm_.robot().chain, joint(j)));
    const double low = std::max(min, lowest(j)), high = std::min(max, highest(j));
    const double share = share_of_start(k, j);
    q[joint(j)] = low < high ? low + share * (high - low) : min + share * (max - min);
  }
  return q;
}

// What the makers state of the elbow of such an arm is not known.
void PostureSearch::look_for_another() {
  constexpr int kFew = 40;
  const Branch branch = arm_.branch_at(*found_);
  for (int k = 1; k <= kFew && !is_one_of_several_; ++k) {
    const JointCorrection solution = joints_of_pose(arm_, context_, wanted_, start(k));
    if (!solution.is_reached) continue;
    const auto q = in_ranges(solution.q, true);
    is_one_of_several_ = q && !is_same(branch, arm_.branch_at(*q));
  }
}

void PostureSearch::try_from(const JointVector& start) {
  const JointCorrection solution = joints_of_pose(arm_, context_, wanted_, start);
  if (solution.is_reached) take(solution.q);
}

void PostureSearch::take(const JointVector& solution) {
  is_reached_ = true;
  if (const auto q = in_ranges(solution, true)) {
    (has_sides(*q) ? found_ : in_ranges_only_) = q;
  } else if (!beyond_travel_) {
    beyond_travel_ = in_ranges(solution, false);
    if (beyond_travel_ && !has_sides(*beyond_travel_)) beyond_travel_.reset();
  }
}

// Starts would find the same, but it takes some hundred of them, of several steps each, to show
// that there is none. If the configuration allows several postures, the starts choose one.
bool PostureSearch::look_at_all() {
  const auto all = all_postures(arm_, context_, wanted_);
  if (!all) return false;
  const auto fitting = [&](bool in_travel, bool on_sides) {
    return std::ranges::count_if(*all, [&](const JointVector& solution) {
      const auto q = in_ranges(solution, in_travel);
      return q && (!on_sides || has_sides(*q));
    });
  };
  auto within = fitting(true, true);
  if (within == 0 && stated_.sides_are_weak) within = fitting(true, false);
  if (within > 1 || (within == 0 && !beyond_travel_ && fitting(false, true) > 1)) return false;
  for (const JointVector& solution : *all) take(solution);
  return true;
}

std::optional<JointVector> PostureSearch::in_ranges(JointVector q, bool in_travel) const {
  const KinematicChain& chain = arm_.robot().chain;
  for (int j = 0; j < kProgramAxes; ++j) {
    if (joint(j) < 0) continue;
    const Link& link = joint_link(chain, joint(j));
    double low = lowest(j), high = highest(j);
    if (in_travel) {
      const auto [min, max] = travel(link);
      low = std::max(min, low);
      high = std::min(max, high);
    }
    if (is_prismatic(link)) {
      if (q[joint(j)] < low || q[joint(j)] > high) return std::nullopt;
      continue;
    }
    const auto turned = turned_into(q[joint(j)], low, high, before_ ? (*before_)[joint(j)] : 0);
    if (!turned) return std::nullopt;
    q[joint(j)] = *turned;
  }
  return q;
}

bool PostureSearch::has_sides(const JointVector& q) const {
  const Branch branch = arm_.branch_at(q);
  const auto is_on = [](int side, int reference, int now) { return side * reference * now >= 0; };
  return is_on(stated_.sides[0], reference_.shoulder, branch.shoulder) &&
         is_on(stated_.sides[1], reference_.elbow, branch.elbow) &&
         is_on(stated_.sides[2], reference_.wrist, branch.wrist);
}

}  // namespace armtrue
