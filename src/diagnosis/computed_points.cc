#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "campaign/selection.h"

namespace armtrue {

namespace {

// How closely a robot file predicts no measured points. A nominal one errs as arms are made. A
// calibrated one errs by the noise of the instrument at least, of which a tenth is left as margin.
double closer_than_measured(const Robot& robot) {
  constexpr double kAsNoArmIsMade = 0.01 * kMillimetre;
  constexpr double kAsNoInstrumentReads = 0.001 * kMillimetre;
  constexpr double kOfNoise = 0.1;
  if (!is_calibrated(robot)) return kAsNoArmIsMade;
  if (robot.noise.position <= 0) return kAsNoInstrumentReads;
  return std::min(kAsNoArmIsMade, kOfNoise * robot.noise.position);
}

}  // namespace

bool is_calibrated(const Robot& robot) { return robot.uncertainty || !robot.std.empty(); }

std::optional<std::string> find_computed_points(const Robot& robot, const Campaign& campaign) {
  constexpr size_t kFewestPoses = 10;
  constexpr int kMostRows = 500;
  if (campaign.has_distances() || campaign.has_touches()) return std::nullopt;
  if (std::set<int>(campaign.pose.begin(), campaign.pose.end()).size() < kFewestPoses)
    return std::nullopt;
  std::vector<int> rows(campaign.pose.size());
  std::iota(rows.begin(), rows.end(), 0);
  const Campaign readings = campaign.select(evenly_chosen(rows, kMostRows));
  Robot alone = robot;
  if (!is_calibrated(robot)) alone.effects.clear();
  try {
    const Robot placed = refit_set_up(alone, readings, {"base", "tool"});
    const double miss = median(evaluate(placed, readings).position);
    if (miss > closer_than_measured(robot)) return std::nullopt;
    return fmt::format(
        "the robot file predicts these points to {:.2g} mm (median), as no {}: are they what the "
        "controller computes from the joint angles? Give those that the instrument reads",
        miss / kMillimetre, is_calibrated(robot) ? "instrument reads" : "arm is made");
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

}  // namespace armtrue
