#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace armtrue {

/// A place on a move, t from 0 at its start to 1 at its end, and the displacement wanted there [m].
struct Knot {
  double t;
  Eigen::Vector3d displacement;
};

/// A circular arc.
struct Arc {
  Eigen::Vector3d centre;
  Eigen::Vector3d x, y;  ///< unit vectors in its plane; x points to the start
  double radius;         ///< [m]
  double angle;          ///< from start to end, counted from x to y, in (0, 2 pi) [rad]

  Eigen::Vector3d at(double t) const;
  /// t of the foot of the perpendicular from a point, in [0, 2 pi / angle).
  double foot(const Eigen::Vector3d& point) const;
  /// Of a point from the whole circle.
  double distance(const Eigen::Vector3d& point) const;
};

/// The arc from start to end by way of a third point; none if they lie on a line.
std::optional<Arc> arc_through(const Eigen::Vector3d& start, const Eigen::Vector3d& via,
                               const Eigen::Vector3d& end);

/// The displacement at t, linear between the knots (at least one, t increasing).
Eigen::Vector3d displacement_at(const std::vector<Knot>& knots, double t);

/// At which knots a straight move, displaced, has to be divided so that straight pieces between
/// them stay within the tolerance [m] of every knot, as far as no piece may be shorter than
/// `shortest` [of t]. The first and the last knot are among them.
std::vector<size_t> divide_line(const std::vector<Knot>& knots, double tolerance,
                                double shortest = 0);

/// The same for an arc and circular pieces; a piece goes through what lies half-way on the arc,
/// undivided it goes through the place `via`.
std::vector<size_t> divide_arc(const Arc& arc, double via, const std::vector<Knot>& knots,
                               double tolerance, double shortest = 0);

/// Whether a straight line does for the displaced arc between two of its knots: a controller takes
/// no circle through points that are almost in line.
bool is_straight(const Arc& arc, const std::vector<Knot>& knots, size_t first, size_t last,
                 double tolerance);

}  // namespace armtrue
