#include "diagnosis/computed_points.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

std::optional<std::string> find_computed_points(const Robot& nominal, const PlainFit& fit) {
  constexpr double kAsNoArmIsMade = 0.01 * kMillimetre;
  constexpr size_t kFewestPoses = 10;
  const Campaign& readings = fit.readings;
  if (readings.has_distances() || readings.has_touches()) return std::nullopt;
  // Where links are fitted too, no more is left.
  if (fit.result.spread.position > kAsNoArmIsMade) return std::nullopt;
  if (std::set<int>(readings.pose.begin(), readings.pose.end()).size() < kFewestPoses)
    return std::nullopt;
  try {
    Robot alone = nominal;
    alone.effects.clear();
    const Robot placed = refit_set_up(alone, readings, {"base", "tool"});
    const double rms = summarize(evaluate(placed, readings).position).rms;
    if (rms > kAsNoArmIsMade) return std::nullopt;
    return fmt::format(
        "the robot file predicts these points to {:.2g} mm (RMS), as no arm is made: are they what "
        "the controller computes from the joint angles? Give those that the instrument reads",
        rms / kMillimetre);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

}  // namespace armtrue
