#pragma once

#include <cstdint>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/split.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

struct HoldOut {
  double share = 0.25;     ///< of the poses, at most
  bool by_region = false;  ///< split_by_region(), not split_by_pose()
  std::uint64_t seed = 1;
};

struct HeldOut {
  Split split;
  std::string fewer;  ///< a sentence that fewer poses are held out than asked for; or empty
};

/// The number of equations of a campaign: readings that differ in session, pose or quantity times
/// their coordinates. A repeated reading counts once.
double distinct_equations(const Campaign& campaign);

/// Holds out poses, but not so many that those that remain show less of the robot than all do. The
/// share is halved, at last to nothing, until
///   - choose_identifiable() keeps as many parameters as with all poses, and each session still
///     shows where its instrument stood;
///   - the training poses have a third of the freedom that all have, or twice as many equations as
///     unknowns: with e distinct equations (a repeated reading counts once) and u unknowns,
///     e_training - u >= min((e_all - u) / 3, u). Without freedom a fit follows its noise, and what
///     it predicts of held-out poses says nothing.
/// Otherwise a robot would be judged that is another than the one which is then fitted to all.
HeldOut hold_out(const Robot& robot, const Campaign& campaign, const HoldOut& asked);

}  // namespace armtrue
