#pragma once

#include <optional>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The nominal robot with only base and tool, and the numbers of cameras that it identifies, fitted
/// to the readings, at most 100,000 at equal steps; no standard deviations. `blunders`: rows that
/// are left out, in ascending order.
Robot placed_nominal(const Robot& robot, const Campaign& campaign,
                     const std::vector<int>& blunders = {});

/// Throws std::invalid_argument, with remedy, if more readings are left out (gross poses and
/// blunders) than kept. Throws too, if base and tool are identified or need not be (touches,
/// images, beams) and the mean error of the fit on the kept readings exceeds 20 mm, or if the fit
/// is no solution: by its own weights placed_nominal(), a special case of its model, has smaller
/// residuals. `sound`: the campaign of the fit; `blunders`: its rows that count as blunders.
/// Returns placed_nominal(), or nothing if base or tool should be identified and is not.
std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<int>& blunders,
                                        int gross_rows);
/// The same with `errors`, position_errors() of the fit, known.
std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<double>& errors,
                                        const std::vector<int>& blunders, int gross_rows);

/// placed_nominal() if the readings are of targets, which are placed with the tool, and `fit`
/// identifies the base; else nothing.
std::optional<Robot> placed_on_targets(const Robot& nominal, const CalibrationResult& fit,
                                       const Campaign& campaign);

}  // namespace armtrue
