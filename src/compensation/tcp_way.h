#pragma once

#include <optional>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/effects/context.h"
#include "armtrue/programs/way.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// The straight or circular way by which the TCP comes to a row of a program, and the part of it
/// that leads from the row before to this one: an arc passes its auxiliary point.
struct TcpWay {
  Way way;                  ///< R_0 from the TCP of the row
  double from = 0, to = 1;  ///< in 0 <= t <= 1 of Way::at()
};

/// Motion of the TCP to a row; a joint move if the program states none.
ProgramMotion motion_to(const Program& program, size_t row);

/// Nothing of joint moves, of moves without their other points, and of arcs whose points lie on a
/// line. `start`: the row from which the move starts; `pose_of`: of a
/// row, R_0 from the TCP of `row`.
template <class PoseOf>
std::optional<TcpWay> tcp_way(const Program& program, size_t row, size_t start,
                              const PoseOf& pose_of) {
  const MotionKind kind = motion_to(program, row).kind;
  if (kind == MotionKind::line) return TcpWay{{pose_of(start), pose_of(row), {}}};
  const size_t end = kind == MotionKind::via ? row + 1 : row;
  const ProgramMotion motion = motion_to(program, end);
  if (end < 1 || motion.kind != MotionKind::arc ||
      motion_to(program, end - 1).kind != MotionKind::via)
    return std::nullopt;
  Way way{pose_of(start), pose_of(end), std::nullopt, motion.turning};
  const Eigen::Vector3d via = pose_of(end - 1).translation;
  way.arc = arc_through(way.start.translation, via, way.end.translation);
  if (!way.arc) return std::nullopt;
  const double middle = way.arc->foot(via);
  return end == row ? TcpWay{way, middle, 1} : TcpWay{way, 0, middle};
}

/// Joint angles of two rows between which the TCP moves.
struct JointsOfEnds {
  const JointVector &from, &to;
};

/// The joint angles at `t` of a way that are nearest to `near`; external axes that the program
/// states move evenly, by `share` from end to end. Nothing if the controller's model does not reach
/// it.
std::optional<JointVector> joints_on(const ProgramArm& controller, const Program& program,
                                     const Context& context, const Way& way, double t,
                                     const JointsOfEnds& ends, double share, JointVector near);

/// A place between a row and the one before.
struct Waypoint {
  double share = 1;  ///< of the way from the row before, in (0, 1]
  JointVector q;     ///< [rad or m]
};

/// Places on the way to a row, the row itself the last, dense enough to show where a joint
/// reverses: denser towards the row, because the direction in which a joint arrives there is that
/// of its last motion. The row alone if the controller's model cannot follow the way, or ends at
/// other joint angles.
std::vector<Waypoint> waypoints(const ProgramArm& controller, const Program& program,
                                const Context& context, const TcpWay& part,
                                const JointsOfEnds& ends);

}  // namespace armtrue
