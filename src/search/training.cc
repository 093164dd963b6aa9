#include "search/training.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/worthwhile.h"
#include "calibration/refit.h"
#include "search/evidence.h"

namespace armtrue {
namespace {

// Searches without the gross poses. Effects that the geometry lacks may hide a gross pose, or look
// like one. So gross poses are searched again when the effects are known.
Training trace_sound(const Robot& robot, const Campaign& given, const Catalogue& catalogue,
                     const TraceOptions& options) {
  Training training;
  const auto trace_without = [&](std::vector<GrossPose> gross) {
    training.without_gross =
        gross.empty() ? nullptr : std::make_unique<const Campaign>(without_gross(given, gross));
    training.sound = gross.empty() ? &given : training.without_gross.get();
    training.gross_poses = std::move(gross);
    training.trace = trace(robot, *training.sound, catalogue, options);
  };
  trace_without(find_gross_poses(robot, given));
  if (training.trace.effects.empty()) return training;
  std::vector<GrossPose> gross = find_gross_poses(training.trace.fit.robot, given);
  if (rows_of(gross) != rows_of(training.gross_poses)) trace_without(std::move(gross));
  return training;
}

// The fit without one effect, all else adjusted to that: far from where the fit was linear if the
// effect is a strong one. An error of the instrument goes with the rest that it leaves, which is
// among the effects held: those from `held` to `found`.
Robot without_effect(const CalibrationResult& fit, const Campaign& campaign, size_t held,
                     size_t found, size_t effect) {
  Robot reduced = fit.robot;
  const auto first = reduced.effects.begin();
  const auto at = [&](size_t k) { return first + static_cast<std::ptrdiff_t>(k); };
  const bool with_rest = is_of_instrument(*at(effect));
  reduced.effects.erase(at(effect));
  if (with_rest)
    reduced.effects.erase(
        std::remove_if(at(held), at(found),
                       [](const Effect& other) { return is_polynomial(other.shape); }),
        at(found));
  constexpr double kTolerance = 1e-5;  // an error to three digits is all that is asked of it
  return refit(reduced, campaign, fit, kTolerance).robot;
}

}  // namespace

Training search_training(const Robot& robot, const Campaign& given, Then then,
                         const Catalogue& catalogue, const TraceOptions& options) {
  Training training = trace_sound(robot, given, catalogue, options);
  const Campaign& sound = *training.sound;
  const CalibrationResult& fit = training.trace.fit;
  training.nominal = placed_nominal(robot, sound);
  training.errors.push_back(errors_of(training.nominal, sound));
  for (const CalibrationResult& stage : training.trace.stages)
    training.errors.push_back(errors_of(stage.robot, sound));
  training.quality = assess(fit, sound);
  require_worthwhile(robot, fit, sound, training.quality.blunders, given.rows() - sound.rows());
  if (then == Then::report) return training;
  const size_t effects = fit.robot.effects.size();
  const size_t found = effects - training.trace.effects.size();
  for (size_t k = found; k < effects; ++k)
    training.without_effect.push_back(without_effect(fit, sound, robot.effects.size(), found, k));
  training.if_complete = uncertainty_if_complete(fit, sound);
  return training;
}

}  // namespace armtrue
