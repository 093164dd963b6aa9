#include "armtrue/calibration/worthwhile.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

Robot placed_nominal(const Robot& robot, const Campaign& campaign) {
  Robot placed = robot;
  placed.identify = {"base", "tool"};
  placed.identify_per_session.clear();
  return calibrate(placed, campaign, {.statistics = FitStatistics::weights}).robot;
}

std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<int>& blunders,
                                        int gross_rows) {
  const std::string remedy =
      "; a target, a reflector or the joint angles of several poses may be wrong: look at the "
      "residuals, then correct or leave out those rows, or measure them anew";
  const int all = sound.rows() + gross_rows;
  const int left_out = static_cast<int>(blunders.size()) + gross_rows;
  if (2 * left_out > all)
    throw std::invalid_argument(
        fmt::format("{}: {} of {} readings look like blunders, more than are kept{}", sound.source,
                    left_out, all, remedy));
  const auto identifies = [&](int parameter) {
    return std::ranges::find(fit.set.kept, parameter) != fit.set.kept.end();
  };
  const bool finds_place = identifies(kFirstBaseParameter) || sound.has_touches_only();
  if (!finds_place || !identifies(layout_of(nominal.chain).tool)) return std::nullopt;
  std::optional<Campaign> part;
  if (!blunders.empty()) {
    std::vector<int> rows;
    for (int row = 0; row < sound.rows(); ++row)
      if (!std::ranges::binary_search(blunders, row)) rows.push_back(row);
    part = sound.select(rows);
  }
  const Campaign& kept = part ? *part : sound;
  const auto mean = [&](const Robot& robot) {
    return summarize(evaluate(robot, kept).reading_errors()).mean;
  };
  constexpr double kWorse = 1.02, kExact = 1e-6;  // a robust fit need not have the least mean
  const double fitted = mean(fit.robot);
  constexpr double kImplausibleMean = 0.02;  // m: more than any arm's errors
  if (fitted > kImplausibleMean)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot misses its readings by {:.4g} mm (mean), more than "
                    "any error of an arm{}",
                    sound.source, fitted / kMillimetre, remedy));
  Robot placed_robot = placed_nominal(nominal, kept);
  const double placed = mean(placed_robot);
  if (fitted > kWorse * placed + kExact)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot misses its readings by {:.4g} mm (mean), the nominal "
                    "robot with base and tool placed by {:.4g} mm{}",
                    sound.source, fitted / kMillimetre, placed / kMillimetre, remedy));
  return placed_robot;
}

}  // namespace armtrue
