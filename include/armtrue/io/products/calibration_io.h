#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/io/document.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// Results of a calibration beside the robot.
struct CalibrationFindings {
  std::optional<WeightedZone> zone;
  std::vector<GrossPose> gross;       ///< no fit used them
  std::optional<Robot> nominal;       ///< with base and tool fitted to the readings
  std::optional<FitQuality> quality;  ///< of the fit
};

/// The calibrated robot as an armtrue-robot/1 document with a `calibration:` map: convergence,
/// rank, condition, observability, errors, noise, the zone, what was left out, and each absorbed
/// parameter with the parameters that absorb it.
Document write_calibration(const CalibrationResult& result, const Campaign& campaign,
                           const Provenance& provenance, const CalibrationFindings& findings);
/// `evaluation`: evaluate(result.robot, campaign). It is moved in, because it is as large as the
/// campaign.
Document write_calibration(const CalibrationResult& result, const Campaign& campaign,
                           Evaluation evaluation, const Provenance& provenance,
                           const CalibrationFindings& findings);

}  // namespace armtrue
