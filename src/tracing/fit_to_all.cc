#include "armtrue/calibration/gross_poses.h"
#include "armtrue/tracing/loop.h"
#include "tracing/judged_names.h"

namespace armtrue {

FitToAll fit_to_all(const Robot& given, const LoopResult& result, const Campaign& all,
                    const Catalogue& catalogue) {
  const CalibrationResult& judged = result.trace.fit;
  // Geometry alone is that of calibrate(). Near a fit of few poses its law of readings would stay
  // as it was there, as would that of the two parts of readings among which something moved.
  const bool is_geometry =
      judged.robot.effects.size() == given.effects.size() && judged.set.by_small_angles.empty();
  const bool anew = result.moved || result.angles_read_early || is_geometry;
  FitToAll to_all{{}, find_gross_poses(anew ? given : judged.robot, all), all};
  if (!to_all.gross_poses.empty()) to_all.sound = without_gross(all, to_all.gross_poses);
  CalibrationOptions near;
  near.start_near(judged);
  to_all.fit = anew ? calibrate(given, to_all.sound)
                    : calibrate(judged.robot, to_all.sound, judged.set, near);
  if (!result.applied) return to_all;
  const bool instrument_errs = result.applied->instrument_errs;
  const CalibrationResult lawless =
      instrument_errs ? without_laws(to_all.fit, to_all.sound) : to_all.fit;
  const RandomEffects random = random_effects_beside(
      lawless, to_all.sound, instrument_errs ? &catalogue : nullptr, result.wandering);
  if (random.lasting.empty()) return to_all;
  CalibrationResult applied = applied_arm(lawless, to_all.sound, random);
  // Random effects hold as they were judged, or not at all.
  if (mean_reading_error(applied.robot, to_all.sound) <=
      kCountsAsWorse * mean_reading_error(to_all.fit.robot, to_all.sound))
    to_all.fit = std::move(applied);
  return to_all;
}

}  // namespace armtrue
