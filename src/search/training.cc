#include "search/training.h"

#include <cstddef>
#include <utility>

#include "armtrue/calibration/prediction.h"
#include "calibration/refit.h"

namespace armtrue {
namespace {

// Searches without the gross poses. Effects that the geometry lacks may hide a gross pose, or look
// like one. So gross poses are searched again when the effects are known.
Training trace_sound(const Robot& robot, const Campaign& given, const Catalogue& catalogue,
                     const TraceOptions& options) {
  Training training;
  const auto trace_without = [&](std::vector<GrossPose> gross) {
    training.sound = without_gross(given, gross);
    training.gross_poses = std::move(gross);
    training.trace = trace(robot, training.sound, catalogue, options);
  };
  trace_without(find_gross_poses(robot, given));
  if (training.trace.effects.empty()) return training;
  std::vector<GrossPose> gross = find_gross_poses(training.trace.fit.robot, given);
  if (rows_of(gross) != rows_of(training.gross_poses)) trace_without(std::move(gross));
  return training;
}

// The fit without one effect, with all else refitted. If the effect is strong, this is far from the
// linearization of the fit.
Robot without_effect(const CalibrationResult& fit, const Campaign& campaign, size_t effect) {
  Robot reduced = fit.robot;
  reduced.effects.erase(reduced.effects.begin() + static_cast<std::ptrdiff_t>(effect));
  constexpr double kTolerance = 1e-5;  // an error to three digits is all that is asked of it
  return refit(reduced, campaign, fit, kTolerance).robot;
}

}  // namespace

Training search_training(const Robot& robot, const Campaign& given, Then then,
                         const Catalogue& catalogue, const TraceOptions& options) {
  Training training = trace_sound(robot, given, catalogue, options);
  const Campaign& sound = training.sound;
  const CalibrationResult& fit = training.trace.fit;
  training.nominal = placed_nominal(robot, sound);
  training.errors.push_back(errors_of(training.nominal, sound));
  for (const CalibrationResult& stage : training.trace.stages)
    training.errors.push_back(errors_of(stage.robot, sound));
  training.quality = assess(fit, sound);
  require_worthwhile(robot, fit, sound, training.quality.blunders, given.rows() - sound.rows());
  if (then == Then::report) return training;
  const size_t effects = fit.robot.effects.size();
  for (size_t k = effects - training.trace.effects.size(); k < effects; ++k)
    training.without_effect.push_back(without_effect(fit, sound, k));
  training.if_complete = uncertainty_if_complete(fit, sound);
  return training;
}

}  // namespace armtrue
