#pragma once

#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// Rows of held-out readings that no error of the arm explains: far from the model (some 14
/// standard deviations), while at least half of the readings of their pose, or of the corners of
/// their image, are near it. A reading alone at its pose is never one of them: there the model may
/// be wrong. Ascending; none without a known noise, or if they are too many to be blunders.
std::vector<int> contradicted_rows(const Evaluation& evaluation, const NoiseFloor& noise,
                                   const Campaign& held_out);

}  // namespace armtrue
