#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>

#include "armtrue/search/trace.h"
#include "search/model_search.h"

namespace armtrue {

/// The result of a search, with the evidence of each effect beside all the others, its intervals
/// and rivals. The effect that explains most comes first.
TraceResult with_evidence(SearchResult search, const Campaign& campaign,
                          const TraceOptions& options);

/// BIC: odds of 1000 to 1. The charge for the number of candidates does not count, because it does
/// not come from the readings.
inline const double kRuledOut = 2 * std::log(1000.0);

/// By which share the masses of robot files are off.
inline constexpr double kMassesOff = 0.3;

/// Whether it is, or may be, an error of the instrument that does not change with time.
bool is_of_instrument(const Effect& effect);

/// Whether an effect may be the residual of an event of the instrument: it follows time and moves
/// neither instrument nor base, and another effect of the robot that follows time does.
bool may_be_rest_of_event(const Effect& effect, const Robot& robot);

/// The places at which a step or kink, the k-th chosen candidate, would explain nearly as much (95 %
/// by profile likelihood), extended to the readings around them; nothing for another shape.
std::optional<std::array<double, 2>> step_ci95(EffectModel& model, const Campaign& campaign,
                                               int chosen);

/// Amplitude and phase of the `effect`-th effect of a fit to so many poses, if it is a harmonic;
/// its frequency is taken as exact. `bootstrap_draws` as from bootstrap_coefficients().
std::optional<Cycle> fixed_cycle(const CalibrationResult& fit,
                                 const Eigen::MatrixXd& bootstrap_draws, int effect, int poses);

}  // namespace armtrue
