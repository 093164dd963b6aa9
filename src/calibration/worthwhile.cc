#include "armtrue/calibration/worthwhile.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

namespace {

// Twelve numbers need no more: their standard deviations are then a 300th of the noise.
constexpr int kRowsThatPlace = 100000;

Robot placed_on(const Robot& robot, const Campaign& campaign) {
  Robot placed = robot;
  placed.identify = {"base", "tool"};
  placed.identify_per_session.clear();
  return calibrate(placed, campaign, {.statistics = FitStatistics::weights}).robot;
}

// Of the readings without the rows of blunders. `errors`: of the rows; `first_rows`: see Evaluation.
double mean_error(const std::vector<double>& errors, const std::vector<int>& first_rows,
                  const std::vector<int>& blunders) {
  if (first_rows.empty() && blunders.empty()) return summarize(errors).mean;
  Evaluation kept;
  kept.position.reserve(errors.size());
  size_t reading = 0;
  bool begins = true;
  for (int row = 0; row < std::ssize(errors); ++row) {
    if (reading < first_rows.size() && first_rows[reading] == row) {
      begins = true;
      ++reading;
    }
    if (std::ranges::binary_search(blunders, row)) continue;
    if (begins && !first_rows.empty()) kept.first_rows.push_back(static_cast<int>(kept.position.size()));
    begins = false;
    kept.position.push_back(errors[row]);
  }
  return summarize(kept.reading_errors()).mean;
}

}  // namespace

Robot placed_nominal(const Robot& robot, const Campaign& campaign,
                     const std::vector<int>& blunders) {
  if (campaign.rows() <= kRowsThatPlace && blunders.empty()) return placed_on(robot, campaign);
  std::vector<int> rows = thinned_rows(campaign, std::min(campaign.rows(), kRowsThatPlace));
  std::erase_if(rows, [&](int row) { return std::ranges::binary_search(blunders, row); });
  return placed_on(robot, campaign.select(rows));
}

std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<int>& blunders,
                                        int gross_rows) {
  return require_worthwhile(nominal, fit, sound, position_errors(fit.robot, sound), blunders,
                            gross_rows);
}

std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<double>& errors,
                                        const std::vector<int>& blunders, int gross_rows) {
  const std::string remedy =
      "; a target, a reflector or the joint angles of several poses may be wrong: look at the "
      "residuals, then correct or leave out those rows, or measure them anew";
  const int all = sound.rows() + gross_rows;
  const auto left_out = std::ssize(blunders) + gross_rows;
  if (2 * left_out > all)
    throw std::invalid_argument(
        fmt::format("{}: {} of {} readings look like blunders, more than are kept{}", sound.source,
                    left_out, all, remedy));
  const auto identifies = [&](int parameter) {
    return std::ranges::find(fit.set.kept, parameter) != fit.set.kept.end();
  };
  const bool finds_place = identifies(kFirstBaseParameter) || sound.has_touches_only();
  const bool finds_tool = identifies(layout_of(nominal.chain).tool) || sound.has_pixels_only() ||
                          sound.has_beams_only();
  if (!finds_place || !finds_tool) return std::nullopt;
  constexpr double kWorse = 1.02, kExact = 1e-6;  // a robust fit need not have the least mean
  const std::vector<int> first = sound.first_rows_of_readings();
  const double fitted = mean_error(errors, first, blunders);
  constexpr double kImplausibleMean = 0.02;  // m: more than any arm's errors
  if (fitted > kImplausibleMean)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot misses its readings by {:.4g} mm (mean), more than "
                    "any error of an arm{}",
                    sound.source, fitted / kMillimetre, remedy));
  Robot placed_robot = placed_nominal(nominal, sound, blunders);
  const double placed = mean_error(position_errors(placed_robot, sound), first, blunders);
  if (fitted > kWorse * placed + kExact)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot misses its readings by {:.4g} mm (mean), the nominal "
                    "robot with base and tool placed by {:.4g} mm{}",
                    sound.source, fitted / kMillimetre, placed / kMillimetre, remedy));
  return placed_robot;
}

std::optional<Robot> placed_on_targets(const Robot& nominal, const CalibrationResult& fit,
                                       const Campaign& campaign) {
  if (campaign.target_names.empty() ||
      std::ranges::find(fit.set.kept, kFirstBaseParameter) == fit.set.kept.end())
    return std::nullopt;
  return placed_nominal(nominal, campaign);
}

}  // namespace armtrue
