#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

struct RenumberedImages {
  std::vector<int> rows;  ///< ascending
  std::string words;      ///< with the poses; empty if there are none
};

/// Images in which the corners of a board are numbered from its other end: a plain chessboard looks
/// the same after half a turn. With cameras and boards where most images show them, such an image
/// fits ten times better if corner k of n counts as corner n - 1 - k. Only where all readings are
/// pixels; bind_touches() comes before.
RenumberedImages find_renumbered_images(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
