#pragma once

#include <optional>
#include <string>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Position error by an error of the instrument's scale, which no reading shows, because lengths of
/// the arm and the base imitate it: the error of the scale times the distance from the arm's foot,
/// the origin of R_0.
struct UnseenScale {
  double mean_distance = 0, max_distance = 0;  ///< of the readings [m]

  double mean_cost() const { return kReference * mean_distance; }  ///< [m] per 100 ppm
  double max_cost() const { return kReference * max_distance; }    ///< [m] per 100 ppm

 private:
  static constexpr double kReference = 1e-4;  // 100 ppm
};

/// Nothing without readings of an instrument (touches alone).
std::optional<UnseenScale> unseen_scale(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
