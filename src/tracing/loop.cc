#include "armtrue/tracing/loop.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/statistics/summary.h"
#include "armtrue/tracing/predictor.h"
#include "campaign/sessions.h"
#include "statistics/shuffle.h"

namespace armtrue {
namespace {

int count_poses(const Campaign& campaign) {
  return static_cast<int>(std::set<int>(campaign.pose.begin(), campaign.pose.end()).size());
}

StageErrors errors_of(const Evaluation& evaluation) {
  StageErrors errors{summarize(evaluation.position), std::nullopt};
  if (!evaluation.orientation.empty()) errors.orientation = summarize(evaluation.orientation);
  return errors;
}

// Interval of mean(a) - mean(b) when poses, with all their rows, are drawn again.
std::array<double, 2> paired_bootstrap(const std::vector<double>& a, const std::vector<double>& b,
                                       const std::vector<int>& pose, const TraceOptions& options) {
  const int poses = 1 + *std::max_element(pose.begin(), pose.end());
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, 2);  // sum of differences, rows
  for (size_t row = 0; row < a.size(); ++row)
    by_pose.row(pose[row]) += Eigen::RowVector2d(a[row] - b[row], 1);
  const Eigen::MatrixXd sums = drawn_poses(poses, options.bootstrap, options.seed) * by_pose;
  const Eigen::VectorXd means = sums.col(0).cwiseQuotient(sums.col(1));
  return percentile_interval({means.begin(), means.end()}, poses);
}

Stage stage_of(const std::string& name, int parameters, const Robot& robot,
               const Campaign& training, const Campaign& held_out) {
  Stage stage{name, parameters, errors_of(evaluate(robot, training)), {}};
  if (held_out.rows() > 0) stage.held_out = errors_of(evaluate(robot, held_out));
  return stage;
}

// The nominal robot as it is met in a cell: only base and tool have been set up.
Robot placed(const Robot& robot, const Campaign& campaign) {
  Robot placed = robot;
  placed.identify = {"base", "tool"};
  placed.identify_per_session.clear();
  CalibrationOptions options;
  return calibrate(placed, campaign, options).robot;
}

// The fit without one effect, all else adjusted to that: far from where the fit was linear if the
// effect is a strong one.
Robot without_effect(const CalibrationResult& fit, const Campaign& campaign, size_t effect) {
  Robot reduced = fit.robot;
  reduced.effects.erase(reduced.effects.begin() + static_cast<std::ptrdiff_t>(effect));
  CalibrationOptions options;
  options.start_near(fit);
  options.tolerance = 1e-5;  // an error to three digits is all that is asked of it
  return calibrate(reduced, campaign, fit.set, options).robot;
}

// A cycle whose frequency was settled anew stays what it is.
bool same_but_for_refinement(const Effect& a, const Effect& b) {
  return same_place(a, b) && a.shape.kind == b.shape.kind &&
         std::abs(a.shape.harmonic - b.shape.harmonic) < 1;
}

// What came and what went from one model to the next: an effect that enters may take the place of
// others.
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

}  // namespace

std::string describe(const Effect& effect) {
  return effect.parameter + " follows " + to_string(effect.driver) + " (" +
         to_string(effect.shape) + ")";
}

Split split_by_pose(const Campaign& campaign, double share, std::uint64_t seed) {
  const std::vector<int> pose = campaign.pose_by_id();
  const std::set<int> distinct(pose.begin(), pose.end());
  std::vector<int> poses(distinct.begin(), distinct.end());
  shuffle(poses, seed);
  const auto count = static_cast<size_t>(std::lround(share * static_cast<double>(poses.size())));
  const std::set<int> held_out(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(count));
  Split split;
  for (int row = 0; row < campaign.rows(); ++row)
    (held_out.contains(pose[row]) ? split.held_out : split.training).push_back(row);
  return split;
}

LoopResult close_loop(const Robot& robot, const Campaign& training, const Campaign& held_out,
                      const Catalogue& catalogue, const TraceOptions& options) {
  require_known_sessions(training, held_out);
  LoopResult result;
  result.of_distances = training.has_distances();
  result.training_poses = count_poses(training);
  result.held_out_poses = count_poses(held_out);
  result.rows = training.rows() + held_out.rows();
  result.trace = trace(robot, training, catalogue, options);

  const Robot nominal = placed(robot, training);
  result.stages.push_back(stage_of("nominal", 0, nominal, training, held_out));
  for (size_t k = 0; k < result.trace.stages.size(); ++k) {
    const CalibrationResult& fit = result.trace.stages[k];
    const std::string name =
        k == 0 ? "geometric" : changes(result.trace.stages[k - 1].robot, fit.robot);
    result.stages.push_back(
        stage_of(name, static_cast<int>(fit.names.size()), fit.robot, training, held_out));
  }
  const Robot& final_robot = result.trace.fit.robot;
  const Robot& geometric_robot = result.trace.stages.front().robot;
  const FitQuality quality = assess(result.trace.fit, training);
  for (int row : quality.blunders) result.excluded_rows.push_back(training.line[row]);
  result.noise = quality.noise;
  result.lack_of_fit = quality.lack_of_fit;
  result.floor = mean_error_of_noise(result.noise.position, result.noise.axes);
  if (const std::vector<double>& own = training.sigma_position;
      !own.empty())  // it is of the median
    result.floor *= std::accumulate(own.begin(), own.end(), 0.0) /
                    (static_cast<double>(own.size()) * median(own));

  const size_t declared = final_robot.effects.size() - result.trace.effects.size();
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    result.curves.push_back(
        effect_curve(result.trace.fit, training, declared + k, result.trace.bootstrap_draws));

  if (held_out.rows() > 0) {
    const std::vector<int> poses = held_out.pose_by_id();
    const Evaluation before = evaluate(geometric_robot, held_out);
    const Evaluation after = evaluate(final_robot, held_out);
    result.errors_before = before.position;
    result.errors_after = after.position;
    result.before = summarize(before.position).mean;
    result.after = summarize(after.position).mean;
    const double reducible = result.before * result.before - result.floor * result.floor;
    if (reducible > 0)
      result.reducible_removed = std::clamp(
          (result.before * result.before - result.after * result.after) / reducible, 0.0, 1.0);
    result.gain_ci95 = paired_bootstrap(before.position, after.position, poses, options);
    for (size_t k = 0; k < result.trace.effects.size(); ++k) {
      const Evaluation without =
          evaluate(without_effect(result.trace.fit, training, declared + k), held_out);
      HeldOutGain& gain = result.gains.emplace_back();
      gain.position = summarize(without.position).mean - result.after;
      gain.ci95 = paired_bootstrap(without.position, after.position, poses, options);
    }
  }
  if (!result.trace.ranking.empty()) result.pattern = describe(result.trace.ranking.front().effect);
  result.verdict = conclude({result.trace.effects, result.lack_of_fit,
                             result.noise.source == NoiseFloor::Source::replicates,
                             result.trace.remaining_p, result.after, result.floor});
  return result;
}

void add_predictor(LoopResult& result, const Campaign& training, const Campaign& held_out,
                   const Catalogue& catalogue, const TraceOptions& options) {
  const CalibrationResult& fit = result.trace.fit;
  if (options.progress) options.progress("looking for what many effects predict together");
  const Robot robot = with_remainder(fit, training, catalogue, options);
  auto unknowns = static_cast<int>(fit.names.size());
  for (size_t k = fit.robot.effects.size(); k < robot.effects.size(); ++k)
    unknowns += static_cast<int>(std::ranges::count_if(
        robot.effects[k].coefficients, [](const Coefficient& c) { return c.value != 0; }));
  const size_t added = robot.effects.size() - fit.robot.effects.size();
  const std::string name = added > 0 ? "+ " + std::to_string(added) + " that only predict, unnamed"
                                     : "+ nothing that would predict better";
  result.predictor = {robot, stage_of(name, unknowns, robot, training, held_out)};
}

std::vector<Stage> stages_and_predictor(const LoopResult& result) {
  std::vector<Stage> stages = result.stages;
  if (result.predictor) stages.push_back(result.predictor->stage);
  return stages;
}

}  // namespace armtrue
