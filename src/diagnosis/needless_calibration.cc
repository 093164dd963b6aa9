#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/worthwhile.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "diagnosis/plain_fit.h"

namespace armtrue {
namespace {

double mean_square(const Evaluation& evaluation) {
  return mean_of(evaluation.position, [](double error) { return error * error; });
}

// Mean square distance of the points of two robots at the readings [m^2].
double mean_square_between(const Evaluation& a, const Evaluation& b) {
  double sum = 0;
  for (size_t row = 0; row < a.residuals.size(); ++row)
    sum += (a.residuals[row] - b.residuals[row]).head<3>().squaredNorm();
  return sum / static_cast<double>(a.residuals.size());
}

// False of a table of one axis: base and tool take up all that its link does.
bool shows_links(const PlainFit& fit) {
  const ParameterLayout layout = layout_of(fit.result.robot.chain);
  return std::ranges::any_of(fit.result.set.kept, [&](int k) { return layout.is_of_links(k); });
}

}  // namespace

std::optional<std::string> find_needless_calibration(const Robot& robot,
                                                     const Campaign& campaign) {
  constexpr double kAsNoArmIsMade = 2e-5;  // of its length: the best are made to ten times as much
  constexpr double kDeviations = 3;
  if (is_calibrated(robot) || campaign.reads_one_number() || campaign.has_touches())
    return std::nullopt;
  double length = 0;
  for (const Link& link : robot.chain.links) length += std::hypot(link.d, link.r);
  const double least = kAsNoArmIsMade * length;
  Robot alone = robot;
  alone.effects.clear();
  try {
    const auto fit = fit_plainly(alone, campaign);
    if (!fit || !shows_links(*fit)) return std::nullopt;
    const Robot placed = placed_nominal(alone, fit->readings);
    const Evaluation by_file = evaluate(placed, fit->readings),
                     by_fit = evaluate(fit->result.robot, fit->readings);
    // Noise alone moves the points of the fit by a share of its square: unknowns / numbers.
    const double numbers = 3.0 * fit->readings.rows();
    const auto unknowns = static_cast<double>(fit->result.set.kept.size());
    const double of_noise = mean_square(by_fit) * unknowns / std::max(1.0, numbers - unknowns);
    const double moved = mean_square_between(by_file, by_fit);
    if (moved > least * least ||
        moved > of_noise * (1 + kDeviations * std::sqrt(2 / unknowns)))
      return std::nullopt;
    return fmt::format(
        "the robot file already fits these readings. Was it calibrated from them? Another "
        "calibration would move its points by {:.2g} mm (RMS), which is noise, and no nominal arm "
        "is so exact. Is the absolute accuracy of the controller active, so that it corrects what "
        "is measured? Then log the joint angles that the arm takes, or switch it off; or are the "
        "joint angles computed from the measured poses?",
        std::sqrt(moved) / kMillimetre);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too few readings
  }
}

}  // namespace armtrue
