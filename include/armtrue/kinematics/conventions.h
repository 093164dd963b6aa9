#pragma once

#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Converts a chain whose links hold standard Denavit-Hartenberg parameters,
///     row = Rot(z, theta) Trans(z, r) Trans(x, d) Rot(x, alpha),
/// into the modified convention: each link gets alpha and d of the row before it, the tool those of
/// the last row. Throws std::invalid_argument if a row has beta.
KinematicChain from_standard(const KinematicChain& rows);

/// Returns modified_from_standard: the frame of a link in the modified convention, from that of its
/// row in the standard convention.
Pose modified_from_standard(const Link& row);

/// The links from the part on a positioner to the foot of the arm, with which a chain begins. A
/// joint seen from its other side turns the other way about the same axis, so the axes stand in
/// reverse order with the opposite sign.
struct PartToFoot {
  Pose base;                ///< R_A, the frame of the part, from the frame of the last axis
  std::vector<Link> links;  ///< the axes from the part to the ground, then the link to R_0, fixed
};

/// `positioner`: base the common frame from the foot of the positioner, links in the order in which
/// they carry each other, tool the last axis from the part. `base_of_arm`: the common frame from
/// R_0. The last link is called `foot`. Throws std::invalid_argument if a link has beta: nominal
/// axes need none, and the way back does not keep it.
PartToFoot part_to_foot(const KinematicChain& positioner, const Pose& base_of_arm);

}  // namespace armtrue
