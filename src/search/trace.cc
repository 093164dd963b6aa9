#include "armtrue/search/trace.h"

#include <algorithm>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/parameters.h"
#include "campaign/selection.h"
#include "search/evidence.h"

namespace armtrue {
namespace {

// More poses would find smaller effects, but the cost grows in proportion; only the fit uses all.
constexpr int kMaxPosesOfSearch = 2000;

// Fits the effects that were found with some of the poses to all poses.
void refit_to_all(const Robot& robot, const Campaign& campaign, const TraceOptions& options,
                  TraceResult& result) {
  if (options.progress) options.progress("fitting what was found to all poses");
  CalibrationOptions near;
  near.start_near(result.fit);
  near.tolerance = kSearchTolerance;
  result.stages.front() = calibrate(robot, campaign, result.fit.set);
  const CalibrationResult fit = calibrate(result.fit.robot, campaign, result.fit.set, near);
  result.fit = fit;
  result.stages.back() = result.fit;
  if (result.effects.empty()) return;
  const int poses = static_cast<int>(campaign.pose_ids.size());
  result.bootstrap_draws =
      bootstrap_coefficients(result.fit, campaign, options.bootstrap, options.seed);
  set_intervals(result.bootstrap_draws, poses, result.fit.robot);
  const auto declared = static_cast<int>(result.fit.robot.effects.size() - result.effects.size());
  for (size_t k = 0; k < result.effects.size(); ++k) {
    TracedEffect& traced = result.effects[k];
    const int effect = declared + static_cast<int>(k);
    traced.effect = result.fit.robot.effects[effect];
    const Cycle before = traced.cycle.value_or(Cycle{});
    traced.cycle = fixed_cycle(result.fit, result.bootstrap_draws, effect, poses);
    if (!traced.cycle) continue;
    traced.cycle->frequency_std = before.frequency_std;
    traced.cycle->frequency_ci95 = before.frequency_ci95;
  }
}

// Sets the mean of the effects that may be the instrument's.
void note_means(const Campaign& campaign, TraceResult& result) {
  const Robot& robot = result.fit.robot;
  const auto declared = robot.effects.size() - result.effects.size();
  for (size_t k = 0; k < result.effects.size(); ++k) {
    Effect& fitted = result.fit.robot.effects[declared + k];
    const auto parameter = find_parameter(robot.chain, fitted.parameter);
    if (!fitted.may_be_instrument || !parameter) continue;
    Robot alone = robot;
    alone.effects = {fitted};
    const RobotModel model(alone, campaign.temperature_names);
    double sum = 0, weights = 0;
    for (int row = 0; row < campaign.rows(); ++row) {
      sum += result.fit.weights[row] * model.offsets(campaign.context(row))[*parameter];
      weights += result.fit.weights[row];
    }
    fitted.mean = result.effects[k].effect.mean = sum / std::max(1e-300, weights);
  }
}

}  // namespace

TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options) {
  const bool is_large = static_cast<int>(campaign.pose_ids.size()) > kMaxPosesOfSearch;
  const Campaign& searched =
      is_large ? campaign.select(rows_of_some_poses(campaign, kMaxPosesOfSearch)) : campaign;
  TraceResult result =
      with_evidence(search_effects(robot, searched, catalogue, options), searched, options);
  if (is_large) refit_to_all(robot, campaign, options, result);
  note_means(campaign, result);
  return result;
}

}  // namespace armtrue
