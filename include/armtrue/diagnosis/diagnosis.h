#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Finds mistakes in a file from its numbers: wrong units, exchanged columns, a left-handed frame,
/// orientations in another convention, a joint that counts the other way. Empty if all is
/// plausible.
///
/// Base and tool are fitted in full first: both may stand anywhere. If the median error is then at
/// most 20 mm (and the rotation of the tool from pose to pose at most 0.1 rad), all is plausible.
/// Otherwise each mistake is corrected in turn, with base and tool fitted anew, and the best is
/// named with its remedy if it lowers the median error to a tenth. A mistake that three poses or
/// more share, and the others do not have, is named too. If there is none, the readings are
/// calibrated: they are named as no readings of this robot if the median error stays above 20 mm,
/// or if a link changes by more than 100 mm or 0.5 rad.
std::vector<std::string> diagnose(const Robot& robot, const Campaign& campaign);

/// The mean error [m] above which a calibrated arm has no effect left but a mistake: 20 times the
/// noise of a coordinate [m], and a millimetre for each metre of the arm, the sum of its links.
double largest_credible_error(const KinematicChain& chain, double noise);

}  // namespace armtrue
