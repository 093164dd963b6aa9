#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Rows whose stated standard deviation (`sigma_position`) is wrong by a factor of ten or more, as
/// by another unit: it is at most a tenth of the usual one (median), or ten times that or more, and
/// these rows scatter as all others do about a robust fit that takes all rows for equal. Only where
/// the others scatter as they state: if the model lacks something, exact rows are as far off as
/// others. Nothing for covariances and touches. Ascending.
std::vector<int> wrong_deviations(const Robot& robot, const Campaign& campaign);

/// Gives these rows the usual standard deviation of the others. A sentence that names them; empty
/// if there are none.
std::string trust_usual_deviation(const Robot& robot, Campaign& campaign);

}  // namespace armtrue
