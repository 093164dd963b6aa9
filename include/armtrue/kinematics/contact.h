#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Whether the touch of a contact reads three coordinates, and not a distance alone.
constexpr bool reads_point(ContactKind kind) {
  return kind == ContactKind::point || kind == ContactKind::artefact;
}

/// One number that a touch reads, and its derivative by the touching point.
struct TouchReading {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// What a touch at `u`, in the axes of the contact [m], reads: f(u) of ContactKind. `point`: index
/// into the points of an artefact. `axis`: the coordinate, 0 to 2; any of a plane or a sphere.
TouchReading touch_reading(const Contact& contact, int point, int axis, const Eigen::Vector3d& u);

}  // namespace armtrue
