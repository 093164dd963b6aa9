#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Says that the points are not measured but computed: the robot file itself, with base and tool
/// placed, predicts them to 0.01 mm (RMS), as no arm is made. So does an export of the positions
/// that the controller shows in place of those of the instrument. Nothing for fewer than ten poses,
/// for distances and for touches.
std::optional<std::string> find_computed_points(const Robot& nominal, const PlainFit& fit);

}  // namespace armtrue
