#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/zone.h"
#include "armtrue/io/provenance.h"

namespace armtrue {

/// Where the arm shall be accurate, and how many of the readings lie there.
struct WeightedZone {
  Zone zone;
  int readings_inside;
};

/// The calibrated robot as an armtrue-robot/1 document with a `calibration:` map: convergence,
/// rank, condition, observability, errors, the zone, the gross poses that were left out, and each
/// absorbed parameter with the parameters that absorb it.
std::string write_calibration(const CalibrationResult& result, const Campaign& campaign,
                              const Provenance& provenance,
                              const std::optional<WeightedZone>& weighted_zone = std::nullopt,
                              const std::vector<GrossPose>& gross = {});

}  // namespace armtrue
