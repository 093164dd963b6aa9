#include "programs/kuka/krl_starts.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/pose.h"

namespace armtrue {
namespace {

const char* reason_of(KrlTargetKind kind) {
  switch (kind) {
    case KrlTargetKind::undeclared:
      return "its point is declared neither here nor in the .dat of the program; give the data "
             "list that declares it, or a folder with it: --with FILE";
    case KrlTargetKind::home:
      return "HOME, which $config.dat declares and other programs use; give it: --with "
             "'$config.dat'";
    case KrlTargetKind::here:
      return "it goes where the arm stands";
    case KrlTargetKind::reassigned:
      return "its point is given several values, or changed at run time";
    case KrlTargetKind::frame:
    case KrlTargetKind::axes:
      return "";
    case KrlTargetKind::expression:
      break;
  }
  return "its target is an expression or has no plain numbers";
}

// Joint angles are the same in all frames.
bool is_joints(const KrlMove& move) {
  return move.motion != KrlMotion::circle && move.target.kind == KrlTargetKind::axes;
}

bool is_same(const KrlValues& a, const KrlValues& b) {
  return (a.array() == b.array() || (a.array().isNaN() && b.array().isNaN())).all();
}

}  // namespace

// The first round takes a loop as if it ran once; each further round drops what the rounds before
// do not confirm.
KrlStarts::KrlStarts(const KrlSyntax& syntax, const KrlSetUps::List& set_ups, TargetParts parts)
    : syntax_(syntax),
      set_ups_(set_ups),
      parts_(parts),
      runs_(syntax.moves.size(), false),
      starts_(syntax.moves.size()),
      ends_(syntax.nodes.size()) {
  ends_[KrlFlow::kElsewhere].is_reached = true;
  while (follow_ways()) {
  }
  find_what_runs();
}

// A way comes from outside, from a label or along the text; only a loop leads back.
void KrlStarts::find_what_runs() {
  std::vector<char> runs(syntax_.nodes.size(), false);
  runs[KrlFlow::kElsewhere] = true;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (size_t i = KrlFlow::kElsewhere + 1; i < runs.size(); ++i) {
      if (runs[i]) continue;
      const KrlNode& node = syntax_.nodes[i];
      runs[i] = std::ranges::any_of(node.from, [&](int from) -> bool { return runs[from]; });
      is_changed |= runs[i];
    }
  }
  for (size_t i = 0; i < runs.size(); ++i)
    if (const int move = syntax_.nodes[i].move; move >= 0) runs_[move] = runs[i];
}

// Returns whether anything has changed.
bool KrlStarts::follow_ways() {
  bool is_changed = false;
  for (size_t i = KrlFlow::kElsewhere + 1; i < ends_.size(); ++i) {
    const KrlNode& node = syntax_.nodes[i];
    Start here;
    for (int from : node.from) meet(ends_[from], here);
    const KrlSetUps::SetUp& set_up =
        node.move >= 0 ? set_ups_.of_moves[node.move] : set_ups_.behind[node.set_ups];
    if (!(here.set_up == set_up)) here.values.head<6>() = unknown_krl_values().head<6>();
    here.set_up = set_up;
    if (node.move >= 0) {
      starts_[node.move] = here;
      here = end_of(node.move);
    }
    Start& end = ends_[i];
    is_changed |= here.is_reached != end.is_reached || here.moves != end.moves ||
                  !(here.set_up == end.set_up) || !is_same(here.values, end.values);
    end = here;
  }
  return is_changed;
}

KrlStarts::Start KrlStarts::end_of(size_t move) const {
  Start end{true, unknown_krl_values(), starts_[move].set_up, {}};
  if (!why_left_alone(move).empty()) {
    if (const int axes = syntax_.moves[move].target.only_external; axes >= 0)
      end.values.tail<6>() = inherit(starts_[move].values, syntax_.frames[axes].values).tail<6>();
    return end;
  }
  end.moves = {static_cast<int>(move)};
  if (syntax_.moves[move].circle_angle) return end;
  const KrlTarget& target = syntax_.moves[move].target;
  end.values = reached(move);
  if (target.kind == KrlTargetKind::axes) end.values.head<6>() = unknown_krl_values().head<6>();
  return end;
}

// Joins a way to those that meet here.
void KrlStarts::meet(const Start& way, Start& here) {
  if (!way.is_reached) return;
  if (!here.is_reached) {
    here = way;
    return;
  }
  here.values = common(here.values, way.values);
  if (!(here.set_up == way.set_up)) here.values.head<6>() = unknown_krl_values().head<6>();
  constexpr size_t kMaxWays = 32;  // more ways, of no real program, would take long
  std::vector<int> moves;
  std::ranges::set_union(here.moves, way.moves, std::back_inserter(moves));
  if (here.moves.empty() || way.moves.empty() || moves.size() > kMaxWays) {
    moves.clear();
    here.values = unknown_krl_values();
  }
  here.moves = moves;
}

bool KrlStarts::follows(size_t move) const {
  const std::vector<int>& moves = starts_[move].moves;
  return moves.size() == 1 && moves[0] + 1 == static_cast<int>(move);
}

KrlValues KrlStarts::before_end(size_t move, const KrlValues& before) const {
  KrlValues result = before;
  if (syntax_.moves[move].motion != KrlMotion::circle) return result;
  // Whether the end takes a coordinate that it leaves out from the auxiliary point or the start.
  const KrlFrame& auxiliary = frame_of(syntax_.moves[move].auxiliary);
  result.head<3>() = common(before, inherit(before, auxiliary.values)).head<3>();
  return result;
}

std::string KrlStarts::why_left_alone(size_t index, const KrlValues& before) const {
  const KrlMove& move = syntax_.moves[index];
  const bool is_circle = move.motion == KrlMotion::circle;
  const bool is_relative = move.relative != KrlRelative::none;
  if (move.target.only_external >= 0) return "it moves external axes alone";
  for (const KrlTarget* target : {&move.auxiliary, &move.target})
    if (!is_relative && (target == &move.target || is_circle))
      if (const std::string reason = reason_of(target->kind); !reason.empty()) return reason;
  if (set_ups_.of_moves[index].is_external_tcp && parts_ == TargetParts::pose)
    return "its tool stands in the room (#TCP), and the robot holds the part";
  const bool needs_frames = parts_ == TargetParts::pose && !is_joints(move);
  if (set_ups_.of_moves[index].is_calculated && needs_frames)
    return "its frame is calculated as the program runs ($BASE or $TOOL, by a program that it "
           "calls or that calls it); state them before the move";
  if (set_ups_.of_moves[index].is_interrupted && needs_frames)
    return "it may run with several $BASE, $TOOL or $IPO_MODE: an INTERRUPT or TRIGGER before it "
           "calls " +
           set_ups_.interrupts +
           ", which sets them; state them where that cannot come between, or with the move";
  if (set_ups_.of_moves[index].is_uncertain && needs_frames)
    return "it may run with several $BASE, $TOOL or $IPO_MODE: they depend on " +
           (set_ups_.callers.empty() ? "calls, branches or loops"
                                     : "its calls in " + set_ups_.callers) +
           "; state them before the move";
  if (const std::string& frame = set_ups_.not_followed[index]; !frame.empty() && needs_frames)
    return "its frame is calculated as the program runs: '" + frame +
           "'; if it is always the same, give it: --frame '" + frame + "=x,y,z,a,b,c'";
  if (is_relative) return why_left_alone(move, before);
  if (is_circle)
    if (const std::string reason = why_left_alone(move.auxiliary, before); !reason.empty())
      return reason;
  return why_left_alone(move.target, before_end(index, before));
}

// The pose from which a relative move starts must be known, also where positions suffice: it is
// written out. A controller adds angles in ways that its manual does not state.
std::string KrlStarts::why_left_alone(const KrlMove& move, const KrlValues& before) const {
  const std::string a_relative_move =
      "a relative move; it starts from the corrected point before it";
  if (move.target.kind != KrlTargetKind::frame) return a_relative_move;
  const KrlValues& by = frame_of(move.target).values;
  if ((by.segment<3>(3).array().abs() > 0).any())
    return "a relative move that turns the tool; it starts from the corrected point before it";
  if (by.tail<6>().array().isFinite().any())
    return "a relative move of an external axis; it starts from the corrected point before it";
  return before.head<6>().array().isFinite().all() ? "" : a_relative_move;
}

KrlValues KrlStarts::reached(size_t index) const {
  const KrlMove& move = syntax_.moves[index];
  const KrlValues before = before_end(index);
  const KrlValues& given = frame_of(move.target).values;
  if (move.relative == KrlRelative::none) return inherit(before, given);
  Eigen::Vector3d by = given.head<3>().array().isFinite().select(given.head<3>(), 0.0);
  if (move.relative == KrlRelative::tool)
    by = rotation_from_abc(before[3], before[4], before[5]) * by;
  KrlValues result = before;
  result.head<3>() += by;
  return result;
}

// All numbers of a point must be known.
std::string KrlStarts::why_left_alone(const KrlTarget& target, const KrlValues& before) const {
  const bool is_whole = parts_ == TargetParts::pose;
  const KrlFrame& frame = frame_of(target);
  if (target.kind == KrlTargetKind::axes) {
    const bool is_plain =
        std::ranges::all_of(frame.axes, [](double angle) { return std::isfinite(angle); });
    return is_plain ? "" : "joint angles that are not six plain numbers";
  }
  if (inherit(before, frame.values).head(is_whole ? 6 : 3).array().isFinite().all()) return "";
  return std::string("X, Y, Z") + (is_whole ? ", A, B, C" : "") +
         " are not all stated, and the move before does not state them";
}

const KrlFrame& KrlStarts::frame_of(const KrlTarget& target) const {
  return target.kind == KrlTargetKind::axes ? syntax_.axes[target.axes]
                                            : syntax_.frames[target.frame];
}

}  // namespace armtrue
