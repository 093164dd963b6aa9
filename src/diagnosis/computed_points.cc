#include <fmt/format.h>

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

std::optional<std::string> find_computed_points(const Robot& nominal, const Campaign& campaign) {
  constexpr double kAsNoArmIsMade = 0.01 * kMillimetre;
  constexpr size_t kFewestPoses = 10;
  constexpr int kMostRows = 500;
  if (campaign.has_distances() || campaign.has_touches()) return std::nullopt;
  if (std::set<int>(campaign.pose.begin(), campaign.pose.end()).size() < kFewestPoses)
    return std::nullopt;
  std::vector<int> rows(campaign.pose.size());
  std::iota(rows.begin(), rows.end(), 0);
  const Campaign readings = campaign.select(evenly_chosen(rows, kMostRows));
  Robot alone = nominal;
  alone.effects.clear();
  try {
    const Robot placed = refit_set_up(alone, readings, {"base", "tool"});
    const double miss = median(evaluate(placed, readings).position);
    if (miss > kAsNoArmIsMade) return std::nullopt;
    return fmt::format(
        "the robot file predicts these points to {:.2g} mm (median), as no arm is made: are they "
        "what the controller computes from the joint angles? Give those that the instrument reads",
        miss / kMillimetre);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

}  // namespace armtrue
