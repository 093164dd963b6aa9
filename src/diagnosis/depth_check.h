#pragma once

#include <functional>
#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names a scale of the readings along one direction: an axis of R_A, or the z axis of the measured
/// frame as a camera on the arm has it. A camera with a wrong focal length reads so: its depth is
/// wrong by one factor, width and height are not. With z the coordinate along the direction, the
/// readings are z (1 + e); e is named if it is 0.3 % or more, as no tracker errs, explains a quarter
/// of the residual, and BIC falls by more than 20. Points only.
std::optional<Suspicion> find_depth_scale(const PlainFit& fit);

/// The same for readings so far from the robot file that no calibration succeeds: names the scale
/// (between -20 % and 25 %) that lowers `miss` [m] to a tenth. `miss`: of a robot whose base and
/// tool are fitted.
std::optional<std::string> find_gross_depth_scale(
    const Campaign& campaign, const std::function<double(const Campaign&)>& miss);

}  // namespace armtrue
