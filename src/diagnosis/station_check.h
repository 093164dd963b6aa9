#pragma once

#include <optional>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names a constant of the instrument that all readings share: a length that it adds to every
/// distance along its line of sight, as a wrong constant of the reflector does. It is named if it
/// explains at least half of the residual of the points, and most readings fit better. Points only.
std::optional<Suspicion> find_constant_of_range(const PlainFit& fit);

/// Names what has changed in one session, or from one session on: the zero of a joint, the place of
/// the reflector on the tool, the scale of the instrument, or the constant of its reflector. Each
/// session has a base of its own. What explains most is named if it explains at least a quarter of
/// the residual, and most readings fit better. Nothing for one session.
std::optional<Suspicion> find_change_of_session(const PlainFit& fit);

}  // namespace armtrue
