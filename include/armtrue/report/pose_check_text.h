#pragma once

#include <string>
#include <vector>

#include "armtrue/diagnosis/pose_check.h"

namespace armtrue {

/// Text of a frame of the arm, with its orientation in the angles of each maker's pendant.
std::string frame_text(const ShownFrame& frame);

/// Text of what a pose of the pendant agrees with, or that it agrees with nothing to `within` [m]
/// and `within_angle` [rad]. `links`: number of the last frame.
std::string agreements_text(const std::vector<Agreement>& agreements, int links, double within,
                            double within_angle);

}  // namespace armtrue
