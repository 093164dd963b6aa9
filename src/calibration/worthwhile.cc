#include "armtrue/calibration/worthwhile.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/observation/session_models.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

namespace {

// Twelve numbers need no more: their standard deviations are then a 300th of the noise.
constexpr int kRowsThatPlace = 100000;

std::vector<int> rows_that_place(const Campaign& campaign) {
  return thinned_rows(campaign, std::min(campaign.rows(), kRowsThatPlace));
}

// The numbers of the cameras that the campaign identifies. They belong to the instrument, so a
// nominal robot that is placed has its own.
std::vector<std::string> numbers_of_cameras(const Robot& robot, const Campaign& campaign) {
  if (!campaign.has_pixels()) return {};
  const int contacts = first_contact_parameter(robot.chain);
  std::vector<std::string> names;
  for (const int parameter : choose_identifiable(robot, campaign).kept)
    if (parameter >= contacts && (parameter - contacts) % kParametersOfContact >= kFirstIntrinsic)
      names.push_back(parameter_name(robot.chain, parameter));
  return names;
}

Robot placed_on(const Robot& robot, const Campaign& campaign) {
  Robot placed = robot;
  placed.identify = {"base", "tool"};
  std::ranges::move(numbers_of_cameras(robot, campaign), std::back_inserter(placed.identify));
  placed.identify_per_session.clear();
  return calibrate(placed, campaign, {.statistics = FitStatistics::weights}).robot;
}

// Root of the mean square of the residuals in standard deviations of the fit, by its weights; on
// the rows on which placed_nominal() places. What the fit minimises is concave in the squares: a
// robot that has less of this than the fit has less of that, too.
double weighted_misfit(const Robot& robot, const CalibrationResult& fit, const Campaign& campaign) {
  const std::vector<int> rows = rows_that_place(campaign);
  const Campaign part = campaign.select(rows);
  const SessionModels models(part, robot, {}, fit.sigma);
  const std::vector<Eigen::Vector2d> norms =
      models.squared_norms(Eigen::VectorXd::Zero(models.unknowns()));
  double sum = 0;
  for (size_t k = 0; k < rows.size(); ++k) sum += fit.weights[rows[k]] * norms[k].sum();
  return std::sqrt(sum / (static_cast<double>(rows.size()) * models.row_size()));
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
  std::vector<int> rows = rows_that_place(campaign);
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
  const double mean = mean_error(errors, sound.first_rows_of_readings(), blunders);
  constexpr double kImplausibleMean = 0.02;  // m: more than any arm's errors
  if (mean > kImplausibleMean)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot misses its readings by {:.4g} mm (mean), more than "
                    "any error of an arm{}",
                    sound.source, mean / kMillimetre, remedy));
  Robot placed = placed_nominal(nominal, sound, blunders);
  constexpr double kWorse = 1.02, kExact = 1e-6;  // of the solver, and m where nothing is left
  const double fitted = weighted_misfit(fit.robot, fit, sound);
  const double of_nominal = weighted_misfit(placed, fit, sound);
  // Of a fit that holds the turns of the tool the placed robot is no special case.
  constexpr int kFirstTurn = 3;  // behind x, y, z
  const bool turns_tool =
      !sound.has_orientation() || identifies(layout_of(nominal.chain).tool + kFirstTurn);
  if (turns_tool && fitted > kWorse * of_nominal + kExact / fit.sigma.position)
    throw std::invalid_argument(
        fmt::format("{}: the calibrated robot fits its readings worse than the nominal robot with "
                    "base and tool placed: {:.4g} and {:.4g} standard deviations are left, RMS by "
                    "the weights of the fit{}",
                    sound.source, fitted, of_nominal, remedy));
  return placed;
}

std::optional<Robot> placed_on_targets(const Robot& nominal, const CalibrationResult& fit,
                                       const Campaign& campaign) {
  if (campaign.target_names.empty() ||
      std::ranges::find(fit.set.kept, kFirstBaseParameter) == fit.set.kept.end())
    return std::nullopt;
  return placed_nominal(nominal, campaign);
}

}  // namespace armtrue
