#pragma once

#include <optional>
#include <string>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// armtrue-summary/1: errors of a robot on a campaign, and their prediction if the robot states its
/// uncertainty. `against`: another robot on the same readings, for comparison.
Document write_summary(const Evaluation& evaluation, const Robot& robot, const Campaign& campaign,
                       const Provenance& provenance,
                       const std::vector<Prediction>& predictions = {},
                       const std::optional<Robot>& against = {});

}  // namespace armtrue
