#pragma once

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// A chain whose rows were meant as standard Denavit-Hartenberg parameters,
///     row = Rot(z, theta) Trans(z, r) Trans(x, d) Rot(x, alpha),
/// as the modified chain that it is: each link takes alpha and d of the row before, the tool those
/// of the last. Throws std::invalid_argument if a row has beta.
KinematicChain from_standard(const KinematicChain& rows);

/// The frame of a link in the modified convention from that of its row in the standard one.
Pose modified_from_standard(const Link& row);

}  // namespace armtrue
