#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Whether a touch of the contact reads three coordinates, not one distance.
constexpr bool reads_point(ContactKind kind) {
  return kind == ContactKind::point || kind == ContactKind::artefact;
}

/// One number that a touch reads, and its derivative by the touching point.
struct TouchReading {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// The reading f(u) of ContactKind for a touch at `u`, in the axes of the contact [m]. `point`:
/// index into the points of an artefact. `axis`: the coordinate, 0 to 2; ignored for a plane or a
/// sphere.
TouchReading touch_reading(const Contact& contact, int point, int axis, const Eigen::Vector3d& u);

}  // namespace armtrue
