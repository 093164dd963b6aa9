#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names joints that move with others, by the gears of a wrist or a screw, where the robot file has
/// no coupling or one with another coefficient. With q_i the reading of a joint that turns,
///     theta_j += c q_i  (r_j of one that slides)
/// beside all unknowns of the fit. One such pair, or up to three together, explain 95 % of the
/// squared residual of the positions or of the orientations, with c of 0.005 (0.5 mm/rad) or more,
/// which no compliance reaches, and lower BIC by more than kClearFall.
std::optional<std::string> find_coupling(const PlainFit& fit);

}  // namespace armtrue
