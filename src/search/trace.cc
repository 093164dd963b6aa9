#include "armtrue/search/trace.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/campaign/selection.h"
#include "armtrue/effects/robot_model.h"
#include "armtrue/kinematics/parameters.h"
#include "search/evidence.h"

namespace armtrue {
namespace {

// More poses would find smaller effects, but the cost grows in proportion; only the fit uses all.
// The same holds for visits: the values of drivers that differ between visits take 3 kB for each.
// 50 readings of a pose show it to a seventh of the noise of one; a search of few poses has more.
constexpr int kMaxPosesOfSearch = 2000;
constexpr long kReadingsOfPose = 50, kMinReadingsOfSearch = 5000;

// No law describes an instrument exactly, and lengths and zero offsets would absorb its residual.
// So if a found effect is, or may be, the instrument's, a distortion of space stays in the model
// too, held by their common prior. A found distortion gets this form. False if nothing changed.
bool add_rest_of_instrument(const std::optional<Candidate>& distortion, const Campaign& campaign,
                            TraceResult& result) {
  Robot& robot = result.fit.robot;
  const auto first = robot.effects.end() - std::ssize(result.effects);
  if (!distortion || std::none_of(first, robot.effects.end(), is_of_instrument)) return false;
  auto rest = std::ranges::find_if(
      robot.effects, [](const Effect& effect) { return is_polynomial(effect.shape); });
  if (rest == robot.effects.end())
    rest = robot.effects.insert(first, distortion->effect);
  else if (rest < first || rest->shape.count >= distortion->effect.shape.count)
    return false;
  rest->shape = distortion->effect.shape;
  const BoundEffect bound(*rest, robot, campaign.temperature_names);
  rest->coefficients.assign(bound.coefficient_count(), {});
  return true;
}

// The model with what was found, fitted to all poses once more.
void refit_to_all(const Campaign& campaign, const TraceOptions& options, TraceResult& result) {
  CalibrationOptions near;
  near.start_near(result.fit);
  near.tolerance = kSearchTolerance;
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

// The fit of the parameters that the robot file allows, without effects: an effect would imitate
// the parameters that the file leaves out.
TraceResult geometry_alone(const Robot& robot, const Campaign& campaign) {
  TraceResult result;
  result.fit = calibrate(robot, campaign);
  result.stages = {result.fit};
  return result;
}

// Parameters that the robot file leaves out although the readings show them, whatever effects are
// found beside all parameters.
std::optional<LeftOut> left_out_beside_effects(const Robot& robot, const Campaign& campaign,
                                               const Catalogue& catalogue,
                                               const TraceOptions& options) {
  if (!left_out_but_shown(robot, campaign)) return std::nullopt;
  Robot wide = robot;
  wide.identify = {"auto"};
  const TraceResult found = trace(wide, campaign, catalogue, options);
  Robot with_effects = robot;
  with_effects.effects = found.fit.robot.effects;
  std::optional<LeftOut> left_out = left_out_but_shown(with_effects, campaign);
  for (size_t k = 0; left_out && k < found.effects.size(); ++k)
    left_out->beside.push_back(found.effects[k].effect);
  return left_out;
}

// Marks which of the effects that only their prior holds, from the `first` on, may be the
// instrument's.
void mark_held(size_t first, TraceResult& result) {
  Robot& robot = result.fit.robot;
  for (size_t k = first; k < robot.effects.size() - result.effects.size(); ++k)
    robot.effects[k].may_be_instrument = may_be_rest_of_event(robot.effects[k], robot);
}

// Whether an effect on the scale of the instrument may be the growth of the arm.
bool may_be_growth(const TracedEffect& traced) {
  return is_instrument_parameter(traced.effect.parameter, InstrumentParameter::scale) &&
         std::ranges::any_of(traced.indistinguishable, [](const Rival& rival) {
           return is_arm_scale(rival.effect.parameter);
         });
}

// Sets the mean of the effects that may be the instrument's, or the arm's.
void note_means(const Campaign& campaign, TraceResult& result) {
  const Robot& robot = result.fit.robot;
  const auto found = robot.effects.size() - result.effects.size();
  for (size_t k = 0; k < robot.effects.size(); ++k) {
    Effect& fitted = result.fit.robot.effects[k];
    const auto parameter = find_parameter(robot.chain, fitted.parameter);
    const bool is_doubtful =
        fitted.may_be_instrument || (k >= found && may_be_growth(result.effects[k - found]));
    if (!is_doubtful || !parameter) continue;
    Robot alone = robot;
    alone.effects = {fitted};
    const RobotModel model(alone, campaign.temperature_names);
    double sum = 0, weights = 0;
    for (int row = 0; row < campaign.rows(); ++row) {
      sum += result.fit.weights[row] * model.offsets(campaign.context(row))[*parameter];
      weights += result.fit.weights[row];
    }
    fitted.mean = sum / std::max(1e-300, weights);
    if (k >= found) result.effects[k - found].effect.mean = fitted.mean;
  }
}

// The poses and visits that are searched; none if these are all.
std::optional<Campaign> part_to_search(const Campaign& campaign) {
  std::vector<int> rows = rows_of_some_poses(campaign, kMaxPosesOfSearch);
  const long poses = std::min<long>(std::ssize(campaign.pose_ids), kMaxPosesOfSearch);
  const long most = std::max(kMinReadingsOfSearch, kReadingsOfPose * poses);
  if (std::ssize(rows) > most) rows = rows_of_some_visits(campaign, rows, most);
  if (std::ssize(rows) == campaign.rows()) return std::nullopt;
  return campaign.select(rows);
}

}  // namespace

TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options) {
  if (auto left_out = left_out_beside_effects(robot, campaign, catalogue, options)) {
    TraceResult result = geometry_alone(robot, campaign);
    result.left_out = std::move(left_out);
    return result;
  }
  const std::optional<Campaign> part = part_to_search(campaign);
  const Campaign& searched = part ? *part : campaign;
  SearchResult search = search_effects(robot, searched, catalogue, options);
  const std::optional<Candidate> distortion = search.model.finest_distortion();
  TraceResult result = with_evidence(std::move(search), searched, options);
  const bool has_rest =
      options.instrument_may_err && add_rest_of_instrument(distortion, campaign, result);
  if (part) {
    if (options.progress) options.progress("fitting what was found to all poses");
    result.stages.front() = calibrate(robot, campaign, result.fit.set);
  }
  if (part || has_rest) refit_to_all(campaign, options, result);
  mark_held(robot.effects.size(), result);
  note_means(campaign, result);
  return result;
}

}  // namespace armtrue
