#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/report/report.h"

namespace armtrue {

/// Input of calibration_page() besides the fit.
struct CalibrationStory {
  std::vector<GrossPose> gross;       ///< poses that no fit used
  std::optional<Robot> nominal;       ///< with base and tool fitted to the readings
  FitQuality quality;                 ///< of the fit
  std::optional<std::string> missed;  ///< the criterion that the calibration fails, in words
};

/// The page of a calibration: errors before and after, along the campaign and in the workspace,
/// what to measure next, parameters with their standard deviations and shares of the readings,
/// readings left out. `nominal`: the robot before the calibration. The keys are those of
/// armtrue-robot/1.
Report calibration_page(const CalibrationResult& result, const Robot& nominal,
                        const Campaign& campaign, const CalibrationStory& story,
                        const PageHead& head);

/// Whether the bounds that a robot file promises hold for the readings, see broken_bounds().
enum class Bounds { held_or_unknown, broken };

/// The page of a robot on measured poses. `file`: the robot as its file has it, before a refit;
/// `against`: another robot on the same readings; `bounds`: see broken_bounds(). The keys are
/// those of armtrue-summary/1.
Report evaluation_page(const Robot& robot, const Robot& file, const Campaign& campaign,
                       const Evaluation& evaluation, const std::optional<Robot>& against,
                       const PageHead& head, Bounds bounds = Bounds::held_or_unknown);

}  // namespace armtrue
