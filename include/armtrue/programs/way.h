#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/kinematics/pose.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// A circular arc.
struct Arc {
  Eigen::Vector3d centre;
  Eigen::Vector3d x, y;  ///< unit vectors in its plane; x points to the start
  double radius;         ///< [m]
  double angle;          ///< from start to end, positive from x to y, in (0, 2 pi) [rad]

  /// centre + radius (x cos(t angle) + y sin(t angle)).
  Eigen::Vector3d at(double t) const;
  /// t of the nearest point of the circle, in [0, 2 pi / angle).
  double foot(const Eigen::Vector3d& point) const;
  /// Distance of a point from the whole circle.
  double distance(const Eigen::Vector3d& point) const;
};

/// The arc from start to end through `via`; nothing if the three points lie on a line.
std::optional<Arc> arc_through(const Eigen::Vector3d& start, const Eigen::Vector3d& via,
                               const Eigen::Vector3d& end);

/// The way of the TCP in a straight or circular move, at constant speed from t = 0 to 1.
struct Way {
  Pose start, end;
  std::optional<Arc> arc;  ///< none: a line
  ArcTurning turning = ArcTurning::in_frame;

  /// On a line the rotation is R_start exp(t log(R_start' R_end)). On an arc that turns with its
  /// path it is that in a frame that turns by t * angle about the normal of the arc.
  Pose at(double t) const;
  double length() const;  ///< [m]
};

/// The external axes at t on the way between two targets; NaN where either target does not know
/// them.
std::vector<double> external_between(const ProgramTarget& start, const ProgramTarget& end,
                                     double t);

/// Share of the way to the next point.
inline constexpr double kPassingShare = 0.4;

/// Radius within which a point may be passed without a stop [m]: kPassingShare of the way to the
/// nearer neighbour, at most 10 mm, at least 0.01 mm, else outside of the radii `of_last` and
/// `of_next` of the neighbours. `before`, `behind`: the ways to them.
double passing_radius(double before, double behind, double of_last, double of_next);

/// No piece of an arc that is divided is shorter [rad]. A circle through points almost in line is
/// refused: ABB wants 1 deg between the directions from the start to the two other points, which is
/// an arc of 4 deg (RAPID reference manual, MoveC).
inline constexpr double kShortestArc = 5 * kDegree;

}  // namespace armtrue
