#include "armtrue/diagnosis/stated_deviations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

constexpr double kWrong = 10;

// Errors of all rows about a fit that knows nothing of their standard deviations; none if they are
// too few.
std::vector<double> errors_of_equal_rows(Robot robot, Campaign campaign) {
  constexpr long kMostRows = 500;
  campaign.sigma_position.clear();
  std::vector<int> rows(campaign.rows());
  std::iota(rows.begin(), rows.end(), 0);
  robot.effects.clear();
  robot.identify = {"auto"};
  try {
    const Robot fitted =
        calibrate(robot, campaign.select(readings_evenly_chosen(campaign, rows, kMostRows)),
                  {.statistics = FitStatistics::weights})
            .robot;
    return evaluate(fitted, campaign).position;
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace

std::vector<int> wrong_deviations(const Robot& robot, const Campaign& campaign) {
  constexpr double kAsStated = 3;  // times: the others scatter as they state
  constexpr double kAlike = 0.6;   // of the usual error
  constexpr double kNoChance = 1e-3;
  const std::vector<double>& sigma = campaign.sigma_position;
  if (sigma.empty() || !campaign.whitening.empty() || campaign.has_touches()) return {};
  const auto [least, largest] = std::ranges::minmax_element(sigma);
  if (*largest < kWrong * *least) return {};
  const std::vector<double> errors = errors_of_equal_rows(robot, campaign);
  if (errors.empty()) return {};
  const double usual = median(sigma), usual_error = median(errors);
  const double axes = campaign.reading_size().position;
  const double times = usual_error / (usual * (axes == 1 ? kMedianOfNorm1 : kMedianOfNorm3));
  if (times > kAsStated || times * kAsStated < 1) return {};
  std::vector<int> small, large;
  std::vector<double> errors_of_small;
  double squares = 0;
  for (int row = 0; row < campaign.rows(); ++row)
    if (kWrong * sigma[row] <= usual) {
      small.push_back(row);
      errors_of_small.push_back(errors[row]);
    } else if (sigma[row] >= kWrong * usual) {
      large.push_back(row);
      squares += std::pow(errors[row] / sigma[row], 2);
    }
  std::vector<int> wrong;
  if (!small.empty() && median(errors_of_small) >= kAlike * usual_error) wrong = small;
  const double freedom = axes * static_cast<double>(large.size());
  if (!large.empty() && kWrong * kWrong * squares < freedom * kAsStated * kAsStated &&
      1 - chi_squared_above(squares, freedom) < kNoChance)
    wrong.insert(wrong.end(), large.begin(), large.end());
  std::ranges::sort(wrong);
  return wrong;
}

std::string trust_usual_deviation(const Robot& robot, Campaign& campaign) {
  const std::vector<int> rows = wrong_deviations(robot, campaign);
  if (rows.empty()) return "";
  std::vector<double> others;
  for (int row = 0; row < campaign.rows(); ++row)
    if (!std::ranges::binary_search(rows, row)) others.push_back(campaign.sigma_position[row]);
  const double usual = median(std::move(others)), wrong = campaign.sigma_position[rows.front()];
  for (int row : rows) campaign.sigma_position[row] = usual;
  return fmt::format(
      "{}: sigma_mm is {:.4g} mm in line {}, and readings that state so scatter as the others do: "
      "it "
      "is wrong by a factor of ten or more, as in another unit. They count with the usual {:.4g} "
      "mm; correct {}",
      campaign.source, wrong / kMillimetre, campaign.line[rows.front()], usual / kMillimetre,
      lines_in_words(campaign.lines_of(rows)));
}

}  // namespace armtrue
