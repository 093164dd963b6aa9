#pragma once

#include "armtrue/effects/effect.h"

namespace armtrue {

/// Whether gravity acts by a basis of several values, as in a robot file without masses: the first
/// moments are then part of the coefficients, rad/(m/s2), which are no compliances.
bool has_gravity_basis(const Effect& effect);

}  // namespace armtrue
