#pragma once

#include <optional>
#include <string>

#include "armtrue/effects/robot.h"
#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names the anchor whose distances are all too long or too short by one factor, for example
/// because the drum of a draw-wire has another size. Beside all fitted unknowns, the distances of
/// each anchor get their own scale. The anchor that explains most of the residual is named if it
/// explains at least a quarter, BIC falls by more than kClearFall, see fall_of_bic(), and its scale
/// error is 0.1 % or more. Nothing for points or for one anchor.
std::optional<std::string> find_scale_of_anchor(const PlainFit& fit);

/// Names a factor by which all lengths of the links change together from the robot file to the fit:
/// links do not have such errors, but the unit or scale of the instrument may. With L a length of
/// the file and D its change, s = sum(L D) / sum(L^2) is named if it is 0.1 % or more (steel grows
/// so by 85 K), five standard deviations by the readings, and more than the errors of the lengths
/// explain (p < 1e-4), over three lengths or more that the readings show. How large these are, the
/// scatter of the D about s L says together with what is known of other arms (kUsualErrorOfLength).
std::optional<std::string> find_scale_of_links(const PlainFit& fit, const Robot& nominal);

}  // namespace armtrue
