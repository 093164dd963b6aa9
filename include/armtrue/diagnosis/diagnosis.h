#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Error of a nominal model, base and tool fitted, above which the cause is a mistake [m]: a new
/// arm may have zeros some tenths of a degree off.
inline constexpr double kImplausibleMiss = 0.02;

/// Finds mistakes in a file from its numbers: wrong units, exchanged columns, a left-handed frame,
/// orientations in another convention, a joint with the wrong sign. Empty if all is plausible.
///
/// Each session is tested alone, the largest first. First, base and tool are fitted, because they
/// may be anywhere. If the median error is then at most 20 mm (and the rotation of the tool from
/// pose to pose at most 0.1 rad, if need be with the geometry calibrated to the points), the set-up
/// is plausible. Otherwise a row is looked for from which on the readings lie in another frame, or
/// are of another tool. Then each possible mistake is corrected in turn, with base and tool fitted
/// again. The best correction is reported with its remedy if it lowers the median error to a tenth.
/// A mistake of some poses, three or more, is reported in either case. If no mistake is found and
/// the median error is above 20 mm, a calibration is tried: if its median error stays above 20 mm,
/// or a link changes by more than 100 mm or 0.5 rad, the result says that these are not readings of
/// this robot.
std::vector<std::string> diagnose(const Robot& robot, const Campaign& campaign);

/// Mean error [m] of a calibrated arm above which the cause is a mistake and not an effect: 20
/// times `noise`, that of a coordinate [m], plus 1 mm for each metre of the arm (sum of the lengths
/// of its links).
double largest_credible_error(const KinematicChain& chain, double noise);

}  // namespace armtrue
