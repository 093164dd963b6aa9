#pragma once

#include <Eigen/Core>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// Covariance of the errors of a pose along and about the axes of R_A: position [m], then rotation
/// vector [rad].
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// Which blocks of a covariance a campaign states. The other one is the unit matrix.
struct StatedBlocks {
  bool position = false, rotation = false;
  bool any() const { return position || rotation; }
};

/// Adds the covariance of the next row to the columns sigma_position, sigma_orientation and
/// whitening. Returns false, and adds nothing, unless the covariance is positive definite.
bool add_covariance(const PoseCovariance& covariance, const StatedBlocks& blocks,
                    Campaign& campaign);

/// The blocks that the rows of a campaign state; none without covariances.
StatedBlocks stated_blocks(const Campaign& campaign);
/// The covariance that a row states; the campaign has Campaign::whitening.
PoseCovariance stated_covariance(const Campaign& campaign, int row);

}  // namespace armtrue
