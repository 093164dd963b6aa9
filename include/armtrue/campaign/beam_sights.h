#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {

/// Farthest off the normal of a surface that light comes back to a beam or a scanner [rad].
inline constexpr double kMostIncidence = 60 * kDegree;

/// A beam, and the plane or the face of an artefact on which it may end: indices into the contacts
/// of the chain and into the points of the artefact.
struct BeamSight {
  int beam = 0, contact = 0, point = -1;
  std::string name;  ///< text of its BeamName
};

/// Each beam of the robot with each plane and each face. Throws std::invalid_argument if there is
/// none, a place is unknown, or a beam does not state its range.
std::vector<BeamSight> beam_sights_of(const KinematicChain& chain);

/// Reading of the beam with the measured frame at `a_from_measured` [m]; nothing if it ends beyond
/// its range, on the back of the plane, or by more than 60 deg off its normal. A plane has no edges
/// here.
std::optional<double> beam_reading_at(const KinematicChain& chain, const BeamSight& sight,
                                      const Pose& a_from_measured);

}  // namespace armtrue
