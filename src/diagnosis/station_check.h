#pragma once

#include <optional>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names a constant of the instrument that all readings share: a length that it adds to every
/// distance along its line of sight, as a wrong constant of the reflector does. It is named if it
/// explains at least half of the residual of the points, and most readings fit better. Points only.
std::optional<Suspicion> find_constant_of_range(const PlainFit& fit);

/// Names what is another one in a session, or from a session on, but its base, which each has of
/// its own: the zero of a joint, the place of the reflector on the tool, the scale of the
/// instrument, or the constant of its reflector. What explains most is named if it explains at
/// least a quarter of the residual, and most readings fit better. Nothing for one session.
std::optional<Suspicion> find_change_of_session(const PlainFit& fit);

}  // namespace armtrue
