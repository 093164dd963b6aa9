#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// Where the arm shall be accurate, and how many of the readings lie there.
struct WeightedZone {
  Zone zone;
  int readings_inside;
};

/// What a calibration found beside the robot.
struct CalibrationFindings {
  std::optional<WeightedZone> zone;
  std::vector<GrossPose> gross;       ///< they took no part
  std::optional<Robot> nominal;       ///< with base and tool placed on the readings
  std::optional<FitQuality> quality;  ///< of the fit
};

/// The calibrated robot as an armtrue-robot/1 document with a `calibration:` map: convergence,
/// rank, condition, observability, errors, noise, the zone, what was left out, and each absorbed
/// parameter with the parameters that absorb it.
std::string write_calibration(const CalibrationResult& result, const Campaign& campaign,
                              const Provenance& provenance, const CalibrationFindings& findings);

}  // namespace armtrue
