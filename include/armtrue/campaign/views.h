#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/robot.h"

namespace armtrue {

/// A camera and a board, of which the arm moves one: indices into the contacts of the chain.
struct View {
  int camera = 0, board = 0;
};

/// All such pairs of the robot whose places are known. Throws std::invalid_argument if there is
/// none.
std::vector<View> views_of(const KinematicChain& chain);

/// Whether the camera has the point of the board in its image, `margin` [px] from its edges, with
/// the measured frame at `a_from_measured`, and sees the front of the board.
bool shows(const KinematicChain& chain, const View& view, const Pose& a_from_measured, int point,
           double margin);

/// The pixel in which the camera has the point [px].
Eigen::Vector2d pixel_of(const KinematicChain& chain, const View& view, const Pose& a_from_measured,
                         int point);

/// Names of the corners of the board in the camera's images, as in a campaign: texts of PixelName,
/// in the order of the board's points.
std::vector<std::string> corner_names(const KinematicChain& chain, const View& view);

}  // namespace armtrue
