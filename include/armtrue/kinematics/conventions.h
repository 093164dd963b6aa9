#pragma once

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

}  // namespace armtrue
