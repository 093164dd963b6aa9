#pragma once

#include <optional>
#include <vector>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// What a parameter departs by at one value of a driver, about the mean over the campaign: a
/// constant belongs to the parameter itself.
struct CurvePoint {
  double driver = 0;      ///< [SI]
  double value = 0;       ///< [m, rad]
  double half_width = 0;  ///< of the 95 % interval [m, rad]
};

/// The curve of one effect of a fit, with all others that make the same parameter follow the same
/// driver, at even steps over the values that the driver took, fine enough for its shape. Empty
/// unless one parameter follows one joint angle, the time or a temperature. `bootstrap_draws` as
/// from bootstrap_coefficients().
std::vector<CurvePoint> effect_curve(const CalibrationResult& fit, const Campaign& campaign,
                                     size_t effect, const Eigen::MatrixXd& bootstrap_draws);

/// What comes back most strongly in a curve over a joint angle.
struct StrongestCycle {
  double per_turn = 0;    ///< [cycles per turn]
  double resolution = 0;  ///< one cycle over the travel covered [cycles per turn]
  double amplitude = 0;   ///< [m, rad]
  double share = 0;       ///< of the variance of the curve
};

/// The sine that beside a straight line explains most of a curve over a joint angle [rad], with two
/// cycles or more over its length. None where that is less than a twentieth, or of a curve without
/// points.
std::optional<StrongestCycle> strongest_cycle(const std::vector<CurvePoint>& curve);

}  // namespace armtrue
