#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Joint values of other rows, for each row of a campaign those with which its reading may belong.
struct JointsOfOtherRows {
  std::string words;  ///< `readings stand 1 row later than their joint angles`
  JointRows q;
};

/// Names a mistake that only some of the rows have: lengths in another unit, joint angles in
/// radians, orientations in radians, exchanged columns, an axis with the wrong sign, readings that
/// belong to joint angles of `others`. Nothing if there is none, or for distances.
///
/// Base and tool are fitted to all rows. If the median error stays above `good`, they are fitted
/// many times to six random poses, and the fit with the most rows within `good` is taken. A mistake
/// is named if its correction brings three poses with errors above `good` below `good`, and to a
/// tenth of their errors; `good_turn` [rad] is the same for their orientations.
std::optional<std::string> find_mixed_rows(const Robot& robot, const Campaign& campaign,
                                           const std::vector<JointsOfOtherRows>& others,
                                           double good, double good_turn);

}  // namespace armtrue
