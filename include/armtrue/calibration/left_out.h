#pragma once

#include <optional>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Parameters that `Robot::identify` leaves out although the readings show them: of links, base,
/// tool and what else the readings show.
struct LeftOut {
  std::vector<int> parameters;   ///< that `auto` would identify besides
  double without = 0;            ///< mean error of the fit without them [m]
  double with = 0;               ///< mean error of the fit with them [m]
  std::vector<Effect> beside{};  ///< effects that a search finds beside all parameters
};

/// Compares the fit of what `robot.identify` allows with that of `auto` by the Bayesian information
/// criterion, each pose counted once, because an error of a length is the same at every visit.
/// Nothing where the readings do not show more, or `auto` is identified.
std::optional<LeftOut> left_out_but_shown(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
