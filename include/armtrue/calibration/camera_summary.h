#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"

namespace armtrue {

/// Sentences on the cameras and boards of a calibration from images: their places with 95 % bounds,
/// and the error of the images, in pixels and at the board; where no link is identified (hand-eye
/// alone), also the error of images that the fit has not used, a fifth of the poses at a time, and
/// what identified links would leave of it, if that is clearly less. Empty for other readings.
/// `nominal`: the robot that was calibrated.
std::vector<std::string> cameras_in_words(const Robot& nominal, const CalibrationResult& result,
                                          const Campaign& campaign, const Evaluation& evaluation);

}  // namespace armtrue
