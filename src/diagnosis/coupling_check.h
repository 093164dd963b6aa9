#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names joints that move with others, by the gears of a wrist or a screw, where the robot file has
/// no coupling or one with another coefficient. With q_i the reading of a joint that turns,
///     theta_j += c q_i  (r_j of one that slides)
/// beside all unknowns of the fit. One such pair, or up to three together, explain 95 % of the
/// squared residual of the positions or of the orientations, with c of 0.005 (0.5 mm/rad) or more,
/// which no compliance reaches, and lower BIC by more than kClearFall.
std::optional<std::string> find_coupling(const PlainFit& fit);

/// Couplings in the place of those of a chain, and what is new of them, in words.
struct ChangedCouplings {
  std::vector<Coupling> couplings;
  std::string words;
};

/// The couplings of a chain, one or more of them with the other sign; none if they are many.
std::vector<ChangedCouplings> other_signs_of_couplings(const KinematicChain& chain);

/// Each pair of near joints of which one may follow the other, with the coefficient that the chain
/// has, which may be 0.
std::vector<Coupling> near_couplings(const KinematicChain& chain);

/// The couplings of a chain with this one, in the place of that of the same pair if there is one.
ChangedCouplings with_coupling(const KinematicChain& chain, const Coupling& coupling);

}  // namespace armtrue
