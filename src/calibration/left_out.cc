#include "armtrue/calibration/left_out.h"

#include <algorithm>
#include <cmath>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/effects/identify.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

std::optional<LeftOut> left_out_but_shown(const Robot& robot, const Campaign& campaign) {
  if (identifies_all(robot.identify)) return std::nullopt;
  Robot all = robot;
  all.identify = {"auto"};
  const ParameterLayout layout = layout_of(robot.chain);
  const IdentifiableSet own = choose_identifiable(robot, campaign);
  LeftOut left_out;
  // What is identified stays an unknown, whatever else could take its place.
  IdentifiableSet wider = choose_identifiable(all, campaign);
  for (int parameter : wider.kept)
    if (layout.is_of_links(parameter) && std::ranges::count(own.kept, parameter) == 0)
      left_out.parameters.push_back(parameter);
  const auto count = static_cast<int>(left_out.parameters.size());
  const int poses = campaign.poses();
  const int equations = poses * (campaign.reads_one_number() ? 1 : 3);
  if (count == 0 || equations <= std::ssize(wider.kept)) return std::nullopt;
  constexpr CalibrationOptions kPlain{.statistics = FitStatistics::weights};
  const CalibrationResult narrow = calibrate(robot, campaign, own, kPlain);
  const CalibrationResult wide = calibrate(all, campaign, wider, kPlain);
  const double fall =
      2 * equations * std::log(narrow.sigma.position / wide.sigma.position);
  if (fall <= count * std::log(equations)) return std::nullopt;
  left_out.without = summarize(evaluate(narrow.robot, campaign).reading_errors()).mean;
  left_out.with = summarize(evaluate(wide.robot, campaign).reading_errors()).mean;
  return left_out;
}

}  // namespace armtrue
