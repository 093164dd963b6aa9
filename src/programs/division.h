#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/programs/way.h"

namespace armtrue {

/// A place t on a move, 0 at its start and 1 at its end, with the wanted displacement there [m].
struct Knot {
  double t;
  Eigen::Vector3d displacement;
};

/// The displacement at t, linear between the knots (at least one, t increasing).
Eigen::Vector3d displacement_at(const std::vector<Knot>& knots, double t);

/// Divides a displaced straight move so that its straight pieces pass every knot within the
/// tolerance [m]. Returns the indices of the knots between the pieces, the first and the last
/// included. No piece is shorter than `shortest` [in t], even if the tolerance is then exceeded.
/// Method: Douglas and Peucker (1973), division at the worst knot.
std::vector<size_t> divide_line(const std::vector<Knot>& knots, double tolerance,
                                double shortest = 0);

/// The same for an arc and circular pieces. The auxiliary point of a piece is the displaced point
/// half-way between its ends; the auxiliary point of the undivided arc is at t = `via`.
std::vector<size_t> divide_arc(const Arc& arc, double via, const std::vector<Knot>& knots,
                               double tolerance, double shortest = 0);

/// Whether the displaced arc between two of its knots is straight within the tolerance [m]: a
/// controller refuses a circle through points that are almost in line.
bool is_straight(const Arc& arc, const std::vector<Knot>& knots, size_t first, size_t last,
                 double tolerance);

}  // namespace armtrue
