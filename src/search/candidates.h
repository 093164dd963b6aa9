#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/catalogue.h"
#include "search/scan.h"

namespace armtrue {

/// The catalogue's effects that this campaign could show, inner values (t*, tau) on a grid.
std::vector<Candidate> catalogue_candidates(const Catalogue& catalogue, const Robot& robot,
                                            const Campaign& campaign);

/// The families of the catalogue, each as one candidate of all its effects among `singles`: those
/// with two members or more.
std::vector<Candidate> family_candidates(const std::vector<Candidate>& singles, const Robot& robot,
                                         const Campaign& campaign);

/// Every parameter against every driver, in bases that assume no cause.
std::vector<Candidate> open_candidates(const Robot& robot, const Campaign& campaign);

/// Whether the base or a length follows a joint angle, or a length jumps in time: those of no rigid
/// arm do.
bool is_of_no_arm(const Effect& effect, const KinematicChain& chain);

/// A step or kink at any place of its driver, the time or a joint angle, between two readings (of
/// very many, evenly taken).
std::vector<Candidate> steps_anywhere(const Candidate& step, const Campaign& campaign);

/// The same effect with finer inner values about those it has; none if its shape has no inner
/// value.
std::vector<Candidate> refined_candidates(const Candidate& candidate, const Campaign& campaign);

}  // namespace armtrue
