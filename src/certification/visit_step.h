#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A step between two visits by which all later ones stand aside, as a knock of the instrument, of
/// the foot or of the reflector leaves it, in a sentence with its size and the remedy. With the mean
/// of each place taken off, the residuals are r = H(t - t*) X s + e: s is a shift (and turn) of
/// R_A, or a shift of the reflector in the axes of the tool. Named if the step takes half of
/// the squares or more, is no chance (F, p < 1e-8, all times and causes counted), and a drift (a
/// cubic of time, or an exponential) of the same cause explains less. `places`: the rows of each
/// pose, reflector and session, two or more.
std::optional<std::string> find_visit_step(const Robot& robot, const Campaign& campaign,
                                           const Evaluation& evaluation,
                                           const std::vector<std::vector<int>>& places);

}  // namespace armtrue
