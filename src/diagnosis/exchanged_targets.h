#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Names two targets whose names are exchanged in a part of the readings of one session. With the
/// base of place_base_and_tool(), which all targets share, each reading shows a place on the last
/// link, whatever its target is called. The places of two targets fall into two groups, found by
/// means of two groups: the distance between their middles must be eight times the median distance
/// within them. Then a reading that lies near the middle of the other target's group has the wrong
/// name, and three poses with such readings are a mistake. Points only; nothing for one target.
std::optional<std::string> find_exchanged_targets(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
