#include "armtrue/calibration/left_out.h"

#include <algorithm>
#include <cmath>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/effects/identify.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

std::optional<LeftOut> left_out_but_shown(const Robot& robot, const Campaign& campaign) {
  if (identifies_all(robot.identify)) return std::nullopt;
  Robot all = robot;
  all.identify = {"auto"};
  const IdentifiableSet own = choose_identifiable(robot, campaign);
  LeftOut left_out;
  const IdentifiableSet wider = choose_identifiable(all, campaign);
  for (int parameter : wider.kept)
    if (std::ranges::count(own.kept, parameter) == 0) left_out.parameters.push_back(parameter);
  // Some may take the place of others that are identified: those count as one.
  const auto count = static_cast<int>(std::ssize(wider.kept) - std::ssize(own.kept));
  const int poses = campaign.poses();
  const int positions = poses * (campaign.reads_one_number() ? 1 : 3);
  const int orientations = campaign.has_orientation() ? 3 * poses : 0;
  const int equations = positions + orientations;
  if (count <= 0 || equations <= std::ssize(wider.kept)) return std::nullopt;
  constexpr CalibrationOptions kPlain{.statistics = FitStatistics::weights};
  const CalibrationResult narrow = calibrate(robot, campaign, own, kPlain);
  const CalibrationResult wide = calibrate(all, campaign, wider, kPlain);
  double fall = 2 * positions * std::log(narrow.sigma.position / wide.sigma.position);
  if (orientations > 0)
    fall += 2 * orientations * std::log(narrow.sigma.orientation / wide.sigma.orientation);
  if (fall <= count * std::log(equations)) return std::nullopt;
  left_out.without = mean_reading_error(narrow.robot, campaign);
  left_out.with = mean_reading_error(wide.robot, campaign);
  return left_out;
}

}  // namespace armtrue
