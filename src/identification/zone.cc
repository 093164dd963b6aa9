#include "armtrue/identification/zone.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace armtrue {

void favour(Campaign& campaign, const Zone& zone) {
  if (campaign.has_distances())
    throw std::invalid_argument(campaign.source +
                                ": distances do not show which poses lie in the zone; measure "
                                "points, or leave the zone out");
  // Only the ratios of the standard deviations count.
  const auto rows = static_cast<size_t>(campaign.rows());
  if (campaign.sigma_position.empty()) campaign.sigma_position.assign(rows, 1e-3);
  if (campaign.has_orientation() && campaign.sigma_orientation.empty())
    campaign.sigma_orientation.assign(rows, 1e-3);
  for (size_t row = 0; row < rows; ++row) {
    const double outside =
        std::max(0.0, (campaign.position[row] - zone.centre).norm() - zone.radius);
    const double factor = std::hypot(1.0, outside / zone.radius);
    campaign.sigma_position[row] *= factor;
    if (campaign.has_orientation()) campaign.sigma_orientation[row] *= factor;
  }
}

}  // namespace armtrue
