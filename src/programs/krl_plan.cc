#include "programs/krl_plan.h"

#include <fmt/format.h>

#include <cmath>

#include "armtrue/kinematics/units.h"
#include "armtrue/programs/matching.h"
#include "armtrue/text/input_error.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The poses of all moves; a pose takes what a frame leaves out from the pose before.
std::vector<KrlPlannedMove> planned_poses(const KrlSyntax& syntax) {
  std::vector<KrlPlannedMove> plans;
  plans.reserve(syntax.moves.size());
  KrlValues pose = unknown_krl_values();
  const auto has_frame = [](const KrlTarget& target) {
    return target.kind == KrlTargetKind::frame;
  };
  const auto values = [&](const KrlTarget& target) -> const KrlValues& {
    return syntax.frames[static_cast<size_t>(target.frame)].values;
  };
  for (const KrlMove& move : syntax.moves) {
    if (move.start_unknown) pose = unknown_krl_values();
    KrlPlannedMove plan;
    plan.start = plan.auxiliary = pose;
    plan.end = unknown_krl_values();
    const bool circle = move.motion == KrlMotion::circle;
    if (!move.relative && has_frame(move.target) && (!circle || has_frame(move.auxiliary))) {
      if (circle) {
        plan.auxiliary = inherit(pose, values(move.auxiliary));
        pose = common(pose, plan.auxiliary);
      }
      plan.end = inherit(pose, values(move.target));
      plan.known =
          position(plan.end).allFinite() && (!circle || position(plan.auxiliary).allFinite());
    }
    pose = plan.end;
    if (move.circle_angle) pose = unknown_krl_values();  // the move ends elsewhere
    plans.push_back(plan);
  }
  return plans;
}

// The known points of all moves, in the order in which the tool comes to them.
struct KnownPoints {
  std::vector<size_t> move;
  std::vector<bool> auxiliary;
  Eigen::Matrix3Xd position;
};

KnownPoints known_points(const KrlSyntax& syntax, const std::vector<KrlPlannedMove>& plans) {
  KnownPoints points;
  points.position.resize(3, 2 * static_cast<Index>(plans.size()));
  const auto add = [&](size_t move, bool auxiliary, const KrlValues& pose) {
    points.position.col(static_cast<Index>(points.move.size())) = position(pose);
    points.move.push_back(move);
    points.auxiliary.push_back(auxiliary);
  };
  for (size_t i = 0; i < plans.size(); ++i) {
    if (!plans[i].known) continue;
    if (syntax.moves[i].motion == KrlMotion::circle) add(i, true, plans[i].auxiliary);
    add(i, false, plans[i].end);
  }
  points.position.conservativeResize(Eigen::NoChange, static_cast<Index>(points.move.size()));
  return points;
}

[[noreturn]] void fail_off_path(const KrlProgram& program, const KrlSyntax& syntax,
                                const Path& path, const KnownPoints& points) {
  const NearestPoint nearest = nearest_to(path.position, points.position);
  const Vector3d point = points.position.col(nearest.point) / kMillimetre;
  throw InputError(fmt::format(
      "{}: no point of the program lies on the programmed path; the nearest, in line {} at "
      "({:.3f}, {:.3f}, {:.3f}) mm, is {:.3f} mm off. Is this the program of that path, and are "
      "its coordinates in the $BASE of the program?",
      program.src.name, syntax.moves[points.move[static_cast<size_t>(nearest.point)]].line,
      point.x(), point.y(), point.z(), nearest.distance / kMillimetre));
}

// Fills `from`, `to` and `start_place`, once the other places are known.
void bound_moves(const KrlSyntax& syntax, const Path& path, std::vector<KrlPlannedMove>& plans) {
  double last = 0;
  for (size_t i = 0; i < plans.size(); ++i) {
    plans[i].from = last;
    if (std::isfinite(plans[i].end_place)) last = plans[i].end_place;
    if (i > 0 && !syntax.moves[i].start_unknown && !syntax.moves[i - 1].circle_angle)
      plans[i].start_place = plans[i - 1].end_place;
  }
  last = static_cast<double>(path.samples());
  for (size_t i = plans.size(); i-- > 0;) {
    if (std::isfinite(plans[i].end_place)) last = plans[i].end_place;
    plans[i].to = last;
  }
}

}  // namespace

std::vector<KrlPlannedMove> plan_krl_moves(const KrlProgram& program, const KrlSyntax& syntax,
                                           const Path& path) {
  std::vector<KrlPlannedMove> plans = planned_poses(syntax);
  const KnownPoints points = known_points(syntax, plans);
  if (points.move.empty())
    throw InputError(fmt::format(
        "{}: none of its {} moves goes to a position that is known here; the points of a program "
        "stand in its .dat, which belongs beside it",
        program.src.name, syntax.moves.size()));
  const Eigen::VectorXd places =
      places_in_order(path.position, points.position, kPathMatchTolerance);
  if (places.array().isNaN().all()) fail_off_path(program, syntax, path, points);
  for (size_t k = 0; k < points.move.size(); ++k) {
    KrlPlannedMove& plan = plans[points.move[k]];
    (points.auxiliary[k] ? plan.auxiliary_place : plan.end_place) = places[static_cast<Index>(k)];
  }
  bound_moves(syntax, path, plans);
  return plans;
}

}  // namespace armtrue
