#include "armtrue/tracing/loop.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "campaign/sessions.h"
#include "search/training.h"
#include "tracing/predictor.h"

namespace armtrue {
namespace {

int count_poses(const Campaign& campaign) {
  return static_cast<int>(std::set<int>(campaign.pose.begin(), campaign.pose.end()).size());
}

// Bootstrap interval of mean(a) - mean(b): poses are drawn with replacement, each with all its
// rows.
std::array<double, 2> paired_bootstrap(const std::vector<double>& a, const std::vector<double>& b,
                                       const std::vector<int>& pose, const TraceOptions& options) {
  const int poses = 1 + *std::max_element(pose.begin(), pose.end());
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, 2);  // sum of differences, rows
  for (size_t row = 0; row < a.size(); ++row)
    by_pose.row(pose[row]) += Eigen::RowVector2d(a[row] - b[row], 1);
  const Eigen::MatrixXd sums = drawn_sums(by_pose, options.bootstrap, options.seed);
  const Eigen::VectorXd means = sums.col(0).cwiseQuotient(sums.col(1));
  return percentile_interval({means.begin(), means.end()}, poses);
}

void set_excluded_rows(const Training& training, const Campaign& given, LoopResult& result) {
  for (int row : training.quality.blunders)
    result.excluded_rows.push_back(training.sound->line[row]);
  for (int row : rows_of(result.gross_poses)) result.excluded_rows.push_back(given.line[row]);
  std::ranges::sort(result.excluded_rows);
  result.left_out_together = left_out_together(given, result.excluded_rows);
}

// A cycle with a refined frequency counts as the same effect.
bool same_but_for_refinement(const Effect& a, const Effect& b) {
  return same_place(a, b) && a.shape.kind == b.shape.kind &&
         std::abs(a.shape.harmonic - b.shape.harmonic) < 1;
}

// Added (+) and removed (-) effects between two models: a new effect may replace others.
std::string changes(const Robot& before, const Robot& after) {
  std::vector<Effect> gone = before.effects;
  std::string came, went;
  for (const Effect& effect : after.effects) {
    const auto same = std::find_if(gone.begin(), gone.end(), [&](const Effect& other) {
      return same_but_for_refinement(effect, other);
    });
    if (same != gone.end())
      gone.erase(same);
    else
      came += " + " + describe(effect);
  }
  for (const Effect& effect : gone) went += " - " + describe(effect);
  return came.empty() && went.empty() ? "refitted" : (came + went).substr(1);
}

// The nominal robot first, then each model of the search.
Stage stage_of(size_t k, const Training& training, const std::vector<CalibrationResult>& models,
               const Campaign& held_out) {
  Stage stage{"nominal", 0, training.errors[k], {}};
  const Robot& robot = k == 0 ? training.nominal : models[k - 1].robot;
  if (k > 0) {
    stage.name = k == 1 ? "geometric" : changes(models[k - 2].robot, robot);
    stage.parameters = static_cast<int>(models[k - 1].names.size());
  }
  if (held_out.rows() > 0) stage.held_out = errors_of(robot, held_out);
  return stage;
}

// 99 % quantile of the mean error of a perfect model, as a factor of the floor: with n held-out
// readings and f degrees of freedom of the floor, 1 + 2.33 sqrt(cv^2 / n + 1 / 2f). cv: standard
// deviation over mean of the length of a normal error in one or three axes.
double highest_of_floor(const NoiseFloor& noise, int readings) {
  const double cv = noise.axes == 1 ? 0.756 : 0.422;
  const double by_replicates = noise.source == NoiseFloor::Source::replicates
                                   ? 0.5 / std::max(1, noise.degrees_of_freedom)
                                   : 0.0;
  return 1 + 2.33 * std::sqrt(cv * cv / std::max(1, readings) + by_replicates);
}

// Sets the p of the held-out errors. Returns the factor by which the uncertainty of the unknowns
// raises the error of a complete model over the floor (99 % quantile): sqrt(1 + mean square by the
// unknowns / variance of a reading).
double judge_held_out(const Uncertainty& if_complete, const Campaign& held_out,
                      LoopResult& result) {
  Robot robot = result.trace.fit.robot;
  robot.uncertainty = if_complete;
  result.outside_p = p_of_errors(robot, held_out);
  constexpr double kBeyond = 0.01;
  const MeanSquare by_unknowns = mean_square_by_uncertainty(robot, held_out);
  const double highest = by_unknowns.expected / by_unknowns.freedom *
                         chi_squared_quantile_above(kBeyond, by_unknowns.freedom);
  const double of_reading = robot.uncertainty->reading.position;
  return std::sqrt(1 + highest / std::max(1e-300, result.noise.axes * of_reading * of_reading));
}

// The excess of the squared error over the floor falls with the number of poses.
int poses_to_the_floor(const LoopResult& result, double floor_high) {
  const double excess = result.after * result.after - result.floor * result.floor;
  const double allowed = floor_high * floor_high - result.floor * result.floor;
  if (allowed <= 0) return 0;
  const double poses = result.training_poses * excess / allowed;
  return std::max(1, static_cast<int>(std::ceil(poses)) - result.training_poses);
}

// Errors before and after on the held-out poses, and the held-out gain of each effect.
void set_held_out(const Training& training, const Campaign& held_out, const TraceOptions& options,
                  LoopResult& result) {
  const std::vector<int> poses = held_out.pose_by_id();
  result.errors_before = evaluate(result.trace.stages.front().robot, held_out).position;
  result.errors_after = evaluate(result.trace.fit.robot, held_out).position;
  result.before = summarize(result.errors_before).mean;
  result.after = summarize(result.errors_after).mean;
  const double reducible = result.before * result.before - result.floor * result.floor;
  if (reducible > 0)
    result.reducible_removed = std::clamp(
        (result.before * result.before - result.after * result.after) / reducible, 0.0, 1.0);
  result.gain_ci95 = paired_bootstrap(result.errors_before, result.errors_after, poses, options);
  for (const Robot& robot : training.without_effect) {
    const Evaluation without = evaluate(robot, held_out);
    HeldOutGain& gain = result.gains.emplace_back();
    gain.position = summarize(without.position).mean - result.after;
    gain.ci95 = paired_bootstrap(without.position, result.errors_after, poses, options);
  }
}

void set_verdict(const Training& training, const Campaign& held_out, LoopResult& result) {
  const double raised =
      held_out.rows() > 0 ? judge_held_out(*training.if_complete, held_out, result) : 1;
  const double of_noise = highest_of_floor(result.noise, held_out.rows());
  // However uncertain the unknowns are: an error 30 % above the floor does not count as noise.
  constexpr double kMostOfUnknowns = 1.3;
  const double complete_high = raised * of_noise * result.floor;
  const double floor_high =
      std::min(complete_high, result.floor * std::max(of_noise, kMostOfUnknowns));
  result.worse_than_nominal = held_out.rows() > 0 && result.after > floor_high &&
                              result.after > result.stages.front().held_out.position.mean;
  result.common_backlash =
      common_backlash(result.trace.fit.robot.chain, result.trace.effects);
  result.verdict =
      conclude({result.trace.effects, result.lack_of_fit, result.after, result.floor, floor_high,
                complete_high, result.outside_p, !result.left_out_together.empty(),
                result.common_backlash.has_value()});
  if (result.verdict == Verdict::too_few_poses)
    result.more_poses = poses_to_the_floor(result, floor_high);
}

void set_floor(const Training& training, LoopResult& result) {
  result.noise = training.quality.noise;
  result.lack_of_fit = training.quality.lack_of_fit;
  result.floor = mean_error_of_noise(result.noise.position, result.noise.axes);
  if (const std::vector<double>& own = training.sound->sigma_position;
      !own.empty())  // it is of the median
    result.floor *= std::accumulate(own.begin(), own.end(), 0.0) /
                    (static_cast<double>(own.size()) * median(own));
}

}  // namespace

std::string describe(const Effect& effect) {
  return effect.parameter + " follows " + to_string(effect.driver) + " (" +
         to_string(effect.shape) + ")";
}

LoopResult close_loop(const Robot& robot, const Campaign& given, const Campaign& held_out,
                      const Catalogue& catalogue, const TraceOptions& options) {
  require_known_sessions(given, held_out);
  LoopResult result;
  result.of_touches = given.has_touches();
  result.of_distances = given.has_distances() && !result.of_touches;
  result.training_poses = count_poses(given);
  result.held_out_poses = count_poses(held_out);
  result.rows = given.rows() + held_out.rows();
  Training training = search_training(
      robot, given, held_out.rows() > 0 ? Then::predict : Then::report, catalogue, options);
  result.trace = std::move(training.trace);
  result.gross_poses = std::move(training.gross_poses);
  for (size_t k = 0; k < training.errors.size(); ++k)
    result.stages.push_back(stage_of(k, training, result.trace.stages, held_out));
  set_excluded_rows(training, given, result);
  set_floor(training, result);

  const std::vector<Effect>& effects = result.trace.fit.robot.effects;
  const size_t declared = effects.size() - result.trace.effects.size();
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    result.curves.push_back(effect_curve(result.trace.fit, *training.sound, declared + k,
                                         result.trace.bootstrap_draws));
  result.held.assign(effects.begin() + static_cast<std::ptrdiff_t>(robot.effects.size()),
                     effects.begin() + static_cast<std::ptrdiff_t>(declared));
  if (!result.trace.ranking.empty()) result.pattern = describe(result.trace.ranking.front().effect);
  if (held_out.rows() > 0) set_held_out(training, held_out, options, result);
  set_verdict(training, held_out, result);
  return result;
}

void add_predictor(LoopResult& result, const Campaign& training, const Campaign& held_out,
                   const Catalogue& catalogue, const TraceOptions& options) {
  const CalibrationResult& fit = result.trace.fit;
  if (options.progress) options.progress("looking for what many effects predict together");
  Robot robot = with_remainder(fit, training, catalogue, options);
  auto unknowns = static_cast<int>(fit.names.size());
  for (size_t k = fit.robot.effects.size(); k < robot.effects.size(); ++k)
    unknowns += static_cast<int>(std::ranges::count_if(
        robot.effects[k].coefficients, [](const Coefficient& c) { return c.value != 0; }));
  const size_t added = robot.effects.size() - fit.robot.effects.size();
  const std::string name = added > 0 ? "+ " + std::to_string(added) + " that only predict, unnamed"
                                     : "+ nothing that would predict better";
  robot.uncertainty = uncertainty_of(fit, training);
  Stage stage{name, unknowns, errors_of(robot, training), {}};
  if (held_out.rows() > 0) stage.held_out = errors_of(robot, held_out);
  result.predictor = {robot, std::move(stage)};
}

std::vector<Stage> stages_and_predictor(const LoopResult& result) {
  std::vector<Stage> stages = result.stages;
  if (result.predictor) stages.push_back(result.predictor->stage);
  return stages;
}

}  // namespace armtrue
