#pragma once

#include <optional>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Columns of corners by which the images show a grid, if these are others than those of the robot
/// file: ids that count row by row lie in straight lines only if a row has the right length. The
/// measure is the median over the images of the RMS distance [px] of the corners from the best
/// projective map of the grid; the columns found lower it by a factor of five or more. `board`:
/// index into the chain's contacts. Nothing for boards that are no grids, numbered row by row.
std::optional<int> find_columns_of_board(const Robot& robot, const Campaign& campaign, int board);

}  // namespace armtrue
