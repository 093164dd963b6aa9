#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// A contact, and what of the tool touches it: indices into the contacts of the chain, into the
/// points of an artefact, and into the targets; -1 is the point of the tool.
struct TouchSight {
  int contact = 0, point = -1, target = -1;
  std::string name;         ///< of what is touched, as a campaign has it: `table`, or `bar/2`
  bool from_below = false;  ///< of a plane or a face: the arm stands on its other side
};

/// A pose to be measured.
struct PlannedPose {
  JointVector q;        ///< [rad or m]
  std::string contact;  ///< what is touched there, or the text of a BeamName; else empty
  std::string target;   ///< what touches it; empty: the point of the tool

  bool operator==(const PlannedPose&) const = default;
};

/// All contacts of the robot whose place is known, by every target. Throws std::invalid_argument if
/// there is none.
std::vector<TouchSight> touch_sights_of(const KinematicChain& chain);

/// What the pose touches of these; nothing if its contact is none of them.
std::optional<TouchSight> touch_at(const PlannedPose& pose, const KinematicChain& chain,
                                   const std::vector<TouchSight>& sights);

/// The point that touches, in the measured frame [m].
Eigen::Vector3d touching_point(const KinematicChain& chain, const TouchSight& sight);

/// How far a touch at `place` in R_A [m] is off the surface, or off a point along the axes of the
/// contact, with the derivatives by the place.
Eigen::VectorXd off_surface(const KinematicChain& chain, const TouchSight& sight,
                            const Eigen::Vector3d& place, Eigen::MatrixX3d& gradients);

/// Whether the arm stands on the right side of a plane or a sphere that it touches, by the frame
/// nearest to the tip that is not there itself. A point has no sides.
bool is_on_its_side(const KinematicChain& chain, const TouchSight& sight, const JointVector& q);

}  // namespace armtrue
