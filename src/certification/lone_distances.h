#pragma once

#include <vector>

namespace armtrue {

/// The smallest of those distances of visits from the middle visit of their pose [m] that are too
/// far for the law of the others; infinite if there are none. At most one in twenty, of 20
/// distances or more.
///
/// The law of a distance r is that of m independent axes with Student's t in common,
///     r^2 / (m s^2) ~ F(m, f),
/// of which the data tell m, s and f: each counts by its likelihood for the other distances. With
/// d_1 > d_2 > ... and S_l(r) the chance of a distance above r, the k largest are too far if
///     1.645 k^2 sum over l of w_l (S_l(d_k) / S_l(d_k+1))^k < 3e-5,
/// where 1.645 k^2 shares the chance among all k. Long tails in the data give laws with long tails,
/// so that ordinary visits of such an instrument are not named.
double least_lone_distance(std::vector<double> distances);

}  // namespace armtrue
