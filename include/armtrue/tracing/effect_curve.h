#pragma once

#include <optional>
#include <vector>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Change of a parameter at one value of a driver. Its mean over the campaign is taken off, because
/// a constant belongs to the parameter itself.
struct CurvePoint {
  double driver = 0;      ///< [SI]
  double value = 0;       ///< [m, rad]
  double half_width = 0;  ///< of the 95 % interval [m, rad]
};

/// The curve of one effect of a fit, summed with all others of the same parameter and driver. The
/// points stand at equal steps over the values that the driver took, fine enough for the shape.
/// Empty unless one parameter follows one joint angle, the time or a temperature.
/// `bootstrap_draws`: from bootstrap_coefficients().
std::vector<CurvePoint> effect_curve(const CalibrationResult& fit, const Campaign& campaign,
                                     size_t effect, const Eigen::MatrixXd& bootstrap_draws);

/// Change of the zero offset of a joint with its own angle in the applied arm: named effects and
/// those without a name.
struct JointCurve {
  int joint = 0;
  std::vector<CurvePoint> points;
  std::vector<double> named;  ///< the part of the effects with a name, at each point [m, rad]
};

/// The strongest periodic part of a curve over a joint angle.
struct StrongestCycle {
  double per_turn = 0;    ///< [cycles per turn]
  double resolution = 0;  ///< one cycle over the measured travel [cycles per turn]
  double amplitude = 0;   ///< [m, rad]
  double share = 0;       ///< of the variance of the curve
};

/// Fits a straight line and one sine, with two cycles or more over the length of the curve, and
/// returns the sine that explains most. Nothing if it explains less than 5 % of the variance, or if
/// the curve has fewer than 8 points. The driver is a joint angle [rad].
std::optional<StrongestCycle> strongest_cycle(const std::vector<CurvePoint>& curve);

}  // namespace armtrue
