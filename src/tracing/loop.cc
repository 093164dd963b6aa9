#include "armtrue/tracing/loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "armtrue/calibration/doubts.h"
#include "armtrue/calibration/hold_out.h"
#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/sessions.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/diagnosis/suspicions.h"
#include "armtrue/search/training.h"
#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/random.h"
#include "armtrue/statistics/summary.h"
#include "tracing/contradicted_rows.h"
#include "tracing/joint_curves.h"
#include "tracing/judged_names.h"
#include "tracing/rows_at_steps.h"

namespace armtrue {
namespace {

int count_poses(const Campaign& campaign) {
  return static_cast<int>(std::set<int>(campaign.pose.begin(), campaign.pose.end()).size());
}

// The pose of each reading of an evaluation.
std::vector<int> poses_of_readings(const Campaign& campaign) {
  const std::vector<int> poses = campaign.pose_by_id(), first = campaign.first_rows_of_readings();
  if (first.empty()) return poses;
  std::vector<int> of_readings;
  for (int row : first) of_readings.push_back(poses[row]);
  return of_readings;
}

// Bootstrap interval of mean(a) - mean(b): poses are drawn with replacement, each with all its
// readings.
std::array<double, 2> paired_bootstrap(const std::vector<double>& a, const std::vector<double>& b,
                                       const std::vector<int>& pose, const TraceOptions& options) {
  const int poses = 1 + *std::max_element(pose.begin(), pose.end());
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, 2);  // sum of differences, readings
  for (size_t k = 0; k < a.size(); ++k)
    by_pose.row(pose[k]) += Eigen::RowVector2d(a[k] - b[k], 1);
  const Eigen::MatrixXd sums = drawn_sums(by_pose, options.bootstrap, options.seed);
  const Eigen::VectorXd means = sums.col(0).cwiseQuotient(sums.col(1));
  return percentile_interval({means.begin(), means.end()}, poses);
}

// Bootstrap interval of reducible_removed. The floor of replicates is drawn too, by the normal law
// of its degrees of freedom. Where a draw leaves nothing to reduce, the share may be any.
std::array<double, 2> removed_ci95(const LoopResult& result, const std::vector<int>& pose,
                                   const TraceOptions& options) {
  const int poses = 1 + *std::max_element(pose.begin(), pose.end());
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, 3);  // sums before and after, rows
  for (size_t row = 0; row < pose.size(); ++row)
    by_pose.row(pose[row]) +=
        Eigen::RowVector3d(result.errors_before[row], result.errors_after[row], 1);
  const Eigen::MatrixXd sums = drawn_sums(by_pose, options.bootstrap, options.seed);
  const double relative = result.noise.source == NoiseFloor::Source::replicates
                              ? 1 / std::sqrt(2.0 * std::max(1, result.noise.degrees_of_freedom))
                              : 0;
  Random random(options.seed);
  std::vector<double> least, most;
  for (const auto& sum : sums.rowwise()) {
    const double before = std::pow(sum[0] / sum[2], 2), after = std::pow(sum[1] / sum[2], 2);
    const double floor = std::pow(result.floor * (1 + relative * random.normal()), 2);
    const double removed =
        before > floor ? std::clamp((before - after) / (before - floor), 0.0, 1.0) : -1;
    least.push_back(removed < 0 ? 0 : removed);
    most.push_back(removed < 0 ? 1 : removed);
  }
  return {percentile_interval(std::move(least), poses)[0],
          percentile_interval(std::move(most), poses)[1]};
}

void set_excluded_rows(const Training& training, const Campaign& given, LoopResult& result) {
  const std::vector<int> blunders = training.sound->lines_of(training.quality.blunders),
                         gross = given.lines_of(rows_of(result.gross_poses));
  result.excluded_rows.clear();
  std::ranges::set_union(blunders, gross, std::back_inserter(result.excluded_rows));
  result.left_out_together = left_out_together(given, result.excluded_rows);
}

// Training poses with a reading that is a blunder, or wrong as wholes.
int blunders_in_training(const Training& training) {
  std::set<int> poses;
  for (int row : training.quality.blunders) poses.insert(training.sound->pose[row]);
  return static_cast<int>(poses.size() + training.gross_poses.size());
}

// The held-out poses that are wrong as wholes. The geometry, too, errs there by half as much: where
// it errs less, the effects do.
void set_gross_held_out(const Training& training, const Campaign& held_out, LoopResult& result) {
  constexpr double kShare = 0.5, kNoChance = 0.01;
  if (held_out.rows() == 0) return;
  Robot robot = training.trace.fit.robot;
  robot.uncertainty = training.if_complete->uncertainty;
  result.gross_held_out = find_gross_held_out(robot, held_out);
  if (result.gross_held_out.empty()) return;
  const Evaluation geometry = evaluate(training.trace.stages.front().robot, held_out);
  std::erase_if(result.gross_held_out, [&](const GrossPose& pose) {
    return geometry.position[pose.rows.front()] < kShare * pose.off;
  });
  const int gross = static_cast<int>(result.gross_held_out.size()),
            in_training = blunders_in_training(training);
  result.are_blunders =
      gross > 0 && in_training > 0 && result.left_out_together.empty() &&
      hypergeometric_at_least(gross, result.held_out_poses, gross + in_training,
                              result.held_out_poses + result.training_poses) >= kNoChance;
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
// readings and f degrees of freedom of the floor, 1 + 2.33 sqrt(cv^2 (1 + v^2) / n + 1 / 2f). cv:
// standard deviation over mean of the length of a normal error: 0.42 in three axes, 0.76 in one. v:
// the same of the standard deviations that the rows state.
double highest_of_floor(const NoiseFloor& noise, int readings, const Campaign& held_out) {
  const double mean_square = 3 * noise.points + 1 - noise.points;  // deviation 1 per axis
  const NoiseFloor of_one{.points = noise.points, .position = 1};
  const double cv2 = mean_square / (of_one.mean_error() * of_one.mean_error()) - 1;
  double times = 1;  // 1 + v^2
  if (const std::vector<double>& own = held_out.sigma_position; !own.empty()) {
    const ErrorSummary of_rows = summarize(own);
    times = std::pow(of_rows.rms / of_rows.mean, 2);
  }
  const double by_replicates = noise.source == NoiseFloor::Source::replicates
                                   ? 0.5 / std::max(1, noise.degrees_of_freedom)
                                   : 0.0;
  return 1 + 2.33 * std::sqrt(times * cv2 / std::max(1, readings) + by_replicates);
}

// Sets the p of the held-out errors. Returns the factor by which the uncertainty of the unknowns
// raises the error of a complete model over the floor (99 % quantile): sqrt(1 + mean square by the
// unknowns / variance of a reading).
double judge_held_out(const Training& training, const Campaign& held_out, LoopResult& result) {
  Robot robot = result.trace.fit.robot;
  robot.uncertainty = training.if_complete->uncertainty;
  const RootsOfSessions& roots = training.if_complete->roots;
  result.outside_p = p_of_errors(robot, held_out, usual_sigma(*training.sound), roots);
  constexpr double kBeyond = 0.01;
  const MeanSquare by_unknowns = mean_square_by_uncertainty(robot, held_out, roots);
  const double highest = by_unknowns.expected / by_unknowns.freedom *
                         chi_squared_quantile_above(kBeyond, by_unknowns.freedom);
  const double of_reading = robot.uncertainty->reading.position;
  return std::sqrt(1 + highest / std::max(1e-300, result.noise.axes * of_reading * of_reading));
}

// The excess of the squared error over the floor falls with the number of poses. The error is that
// on which the verdict stands.
int poses_to_the_floor(const LoopResult& result, double floor_high) {
  const double excess = result.after_sound * result.after_sound - result.floor * result.floor;
  const double allowed = floor_high * floor_high - result.floor * result.floor;
  if (allowed <= 0) return 0;
  const double poses = result.training_poses * excess / allowed;
  // The law holds for about as many poses as there are: with some more, the next run says better.
  constexpr int kTimesAsMany = 3;
  return std::clamp(static_cast<int>(std::ceil(std::min(poses, 1e6))) - result.training_poses, 1,
                    std::max(1, kTimesAsMany * result.training_poses));
}

constexpr double kEquationsOfUnknown = 2;  // which the training poses should have, see hold_out()

double unknowns_of(const CalibrationResult& fit) { return static_cast<double>(fit.names.size()); }

// So many that three quarters of the poses have two equations for each unknown.
int poses_to_hold_out(const Training& training, const LoopResult& result) {
  constexpr double kTrained = 0.75;
  const double per_pose = distinct_equations(*training.sound) / std::max(1, result.training_poses);
  const double needed =
      kEquationsOfUnknown * unknowns_of(result.trace.fit) / (kTrained * std::max(1.0, per_pose));
  return std::max(1, static_cast<int>(std::ceil(needed)) - result.training_poses);
}

// Of an effect; `without`: the model without it, `with`: the errors with it.
HeldOutGain gain_over(const Robot& without, const std::vector<double>& with,
                      const Campaign& held_out, const TraceOptions& options) {
  const std::vector<double> errors = evaluate(without, held_out).reading_errors();
  return {summarize(errors).mean - summarize(with).mean,
          paired_bootstrap(errors, with, poses_of_readings(held_out), options)};
}

// Errors before and after on the held-out poses, and the held-out gain of each effect.
// Errors count all of `held_out`, gains those that are `sound`.
void set_held_out(const Training& training, const Campaign& held_out, const Campaign& sound,
                  const TraceOptions& options, LoopResult& result) {
  const std::vector<int> poses = poses_of_readings(held_out);
  result.errors_before = evaluate(result.trace.stages.front().robot, held_out).reading_errors();
  const std::vector<double> named = evaluate(result.trace.fit.robot, held_out).reading_errors();
  result.after_named = summarize(named).mean;
  if (const auto alone = arm_alone(result_of(result).robot, *training.sound))
    result.after_arm = summarize(evaluate(*alone, held_out).reading_errors()).mean;
  result.errors_after =
      result.applied ? evaluate(result.applied->fit.robot, held_out).reading_errors() : named;
  const auto worst = std::ranges::max_element(result.errors_after) - result.errors_after.begin();
  const std::vector<int> first = held_out.first_rows_of_readings();
  const int row = first.empty() ? static_cast<int>(worst) : first[worst];
  result.worst = {held_out.pose_ids[held_out.pose[row]], result.errors_after[worst]};
  result.before = summarize(result.errors_before).mean;
  result.after = summarize(result.errors_after).mean;
  if (result.after_readings && *result.after_readings >= result.after)
    result.after_readings.reset();
  const double reducible = result.before * result.before - result.floor * result.floor;
  if (reducible > 0)
    result.reducible_removed = std::clamp(
        (result.before * result.before - result.after * result.after) / reducible, 0.0, 1.0);
  result.removed_ci95 = removed_ci95(result, poses, options);
  result.gain_ci95 = paired_bootstrap(result.errors_before, result.errors_after, poses, options);
  const std::vector<double> with = evaluate(result.trace.fit.robot, sound).reading_errors();
  for (const Robot& without : training.without_effect)
    result.gains.push_back(gain_over(without, with, sound, options));
}

double standard_error(const std::array<double, 2>& ci95) {
  constexpr double kErrorsIn95 = 3.92;
  return (ci95[1] - ci95[0]) / kErrorsIn95;
}

// Whether a model predicts held-out poses worse than another: by a standard error, and by so much
// that it matters.
bool is_worse(const std::vector<double>& before, const std::vector<double>& after,
              const std::array<double, 2>& gain_ci95) {
  const double gain = summarize(before).mean - summarize(after).mean;
  return gain < -standard_error(gain_ci95) &&
         summarize(after).mean > kCountsAsWorse * summarize(before).mean;
}

bool is_better(const HeldOutGain& gain) { return gain.position > standard_error(gain.ci95); }

// The effects that were found, if held-out poses are predicted worse with them.
std::optional<RejectedModel> rejected_model(const TraceResult& trace, const Campaign& held_out,
                                            const TraceOptions& options) {
  const std::vector<Effect>& effects = trace.fit.robot.effects;
  const size_t declared = trace.stages.front().robot.effects.size();
  if (effects.size() == declared || held_out.rows() == 0) return std::nullopt;
  const std::vector<double> before =
      evaluate(trace.stages.front().robot, held_out).reading_errors();
  const std::vector<double> after = evaluate(trace.fit.robot, held_out).reading_errors();
  const auto gain = paired_bootstrap(before, after, poses_of_readings(held_out), options);
  if (!is_worse(before, after, gain)) return std::nullopt;
  RejectedModel rejected{{}, summarize(after).mean, gain};
  if (!trace.effects.empty()) rejected.p_value = trace.effects.front().evidence.p_value;
  for (const TracedEffect& traced : trace.effects)
    rejected.effects.push_back(describe(traced.effect));
  for (size_t k = declared; k < effects.size() - trace.effects.size(); ++k)
    rejected.effects.push_back(describe(effects[k]));
  return rejected;
}

// Whether all that the search left in the model are effects that their prior alone holds, and
// held-out poses are not predicted better with them, by a standard error. Nothing else speaks for
// them, and an arm without them would become worse.
bool is_against_held(const TraceResult& trace, const Campaign& held_out,
                     const TraceOptions& options) {
  const bool has_held =
      std::ssize(trace.fit.robot.effects) > std::ssize(trace.stages.front().robot.effects);
  if (!has_held || !trace.effects.empty() || held_out.rows() == 0) return false;
  const std::vector<double> with = evaluate(trace.fit.robot, held_out).reading_errors();
  return !is_better(gain_over(trace.stages.front().robot, with, held_out, options));
}

// Whether a camera or a board moved among the images, and no effect explains it: none of time, nor
// others that leave nothing but noise. Effects found beside such a motion imitate it in part, and
// held-out images, which are of both parts, do not show that.
bool something_moved(const Campaign& given, const Training& training) {
  if (!given.has_pixels_only() || training.quality.leaves_noise() == true) return false;
  const TraceResult& trace = training.trace;
  const bool follows_time = std::ranges::any_of(trace.effects, [](const TracedEffect& traced) {
    return traced.effect.driver.follows_course();
  });
  const CalibrationResult& fit = follows_time ? trace.fit : trace.stages.front();
  return explanation_of_rest(fit, *training.sound).has_value();
}

// Whether the training poses alone say too little for an effect: it entered because something is
// missing, but by chance others would, too.
bool is_weak(const TracedEffect& traced, const TraceOptions& options) {
  return traced.evidence.p_value > options.significance_without_lack_of_fit;
}

// Whether held-out poses support an effect as far as it needs that: a weak one without a listed
// cause by a standard error, a weak one with a cause at all.
bool is_supported(const TracedEffect& traced, const HeldOutGain& gain,
                  const TraceOptions& options) {
  if (gain.denied()) return false;
  if (!is_weak(traced, options)) return true;
  return traced.in_words.empty() ? is_better(gain) : gain.position >= 0;
}

// Of the found effects that held-out poses deny in position, or weak ones that they do not support,
// and that they do not support in orientation, the one that raises the error most. Where other
// causes explain as much as one that is not weak, held-out poses deny its name, not that something
// is there.
std::optional<size_t> worst_effect(const Training& training, const Campaign& held_out,
                                   const TraceOptions& options) {
  const Robot& model = training.trace.fit.robot;
  const std::vector<double> with = evaluate(model, held_out).reading_errors();
  const auto turn = [&](const Robot& robot) {
    const auto errors = errors_of(robot, held_out).orientation;
    return errors ? errors->mean : 0;
  };
  std::optional<size_t> worst;
  double least = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < training.trace.effects.size(); ++k) {
    const TracedEffect& traced = training.trace.effects[k];
    if (traced.effect.family) continue;  // not shown alone
    if (is_undecided(traced) && !is_weak(traced, options)) continue;
    const Robot& without = training.without_effect[k];
    const HeldOutGain gain = gain_over(without, with, held_out, options);
    if (is_supported(traced, gain, options) || gain.position >= least ||
        turn(without) > turn(model))
      continue;
    least = gain.position;
    worst = k;
  }
  return worst;
}

// Leaves out found effects that held-out poses deny, the worst first.
void leave_out_worse(JudgedTraining& judged, const Campaign& held_out, const Catalogue& catalogue,
                     const TraceOptions& options, LoopResult& result) {
  if (held_out.rows() == 0) return;
  Training& training = judged.training;
  const Campaign& sound = *training.sound;
  while (const std::optional<size_t> worst = worst_effect(training, held_out, options)) {
    result.without_gain.push_back(describe(training.trace.effects[*worst].effect));
    leave_out_effect(training, *worst, options);
  }
  if (result.without_gain.empty()) return;
  const CalibrationResult& fit = training.trace.fit;
  judged.random =
      judged.instrument_errs
          ? random_effects_beside(without_laws(fit, sound), sound, &catalogue, judged.wandering)
          : random_effects_beside(fit, sound, nullptr, judged.wandering);
}

// Mean held-out error with the effects of this campaign alone.
double left_of_readings(const Robot& all, const Campaign& held_out) {
  return summarize(evaluate(all, in_order_of_visits(held_out)).reading_errors()).mean;
}

// Whether held-out poses speak for random effects. Where joints err more than the instrument does,
// as rounded angles do, the few held-out poses are predicted better by chance: then by a standard
// error. Beside random errors of the instrument the arm need not predict better than beside a law.
bool speak_for(const Robot& applied, const JudgedTraining& judged, const Campaign& held_out,
               const TraceOptions& options) {
  const std::vector<double> after = evaluate(applied, held_out).reading_errors();
  const HeldOutGain gain = gain_over(judged.training.trace.fit.robot, after, held_out, options);
  const double before = summarize(after).mean + gain.position;
  if (judged.instrument_errs) return summarize(after).mean <= kCountsAsWorse * before;
  return judged.random.joints_err ? is_better(gain) : gain.position >= 0;
}

// Sets the applied arm, unless held-out poses speak against random effects.
void set_applied(const JudgedTraining& judged, const Campaign& held_out,
                 const TraceOptions& options, LoopResult& result) {
  const RandomEffects& random = judged.random;
  const Campaign timed = in_order_of_visits(*judged.training.sound);
  CalibrationResult all = beside(
      judged.instrument_errs ? without_laws(judged.training.trace.fit, *judged.training.sound)
                             : judged.training.trace.fit,
      timed, random);
  if (!random.of_campaign.empty() && held_out.rows() > 0 && held_out.source == timed.source)
    result.after_readings = left_of_readings(all.robot, held_out);
  if (random.lasting.empty()) return;
  AppliedArm applied{
      without_campaign(std::move(all), timed, random), {}, random.groups, judged.instrument_errs};
  const Robot& robot = applied.fit.robot;
  if (held_out.rows() > 0) {
    if (!speak_for(robot, judged, held_out, options)) return;
  }
  applied.stage.name = "+ what the arm does besides, without a name";
  applied.stage.parameters = static_cast<int>(applied.fit.names.size());
  applied.stage.training = training_errors(robot, judged.training);
  result.joints = joint_curves(applied.fit, random, *judged.training.sound);
  result.applied = std::move(applied);
}

// The held-out readings without those that the others of their pose contradict.
Campaign sound_held_out(const Campaign& held_out, LoopResult& result) {
  const Evaluation evaluation = evaluate(result.trace.fit.robot, held_out);
  const std::vector<int> rows = contradicted_rows(evaluation, result.noise, held_out);
  result.contradicted_rows = held_out.lines_of(rows);
  return without_rows(held_out, rows);
}

void set_verdict(const Training& training, const Campaign& held_out, LoopResult& result) {
  double raised = 1, after = 0, nominal = 0;
  if (held_out.rows() > 0) {
    const Campaign sound = sound_held_out(held_out, result);
    raised = judge_held_out(training, sound, result);
    const auto mean_of = [](const Robot& robot, const Campaign& readings) {
      return summarize(evaluate(robot, readings).reading_errors()).mean;
    };
    result.after_sound = mean_of(result.trace.fit.robot, sound);
    after = mean_of(result_of(result).robot, held_out);
    nominal = mean_of(result.nominal, held_out);
  }
  const int readings = held_out.readings();
  const double of_noise = highest_of_floor(result.noise, readings, held_out);
  // However uncertain the unknowns are: an error 30 % above the floor does not count as noise.
  constexpr double kMostOfUnknowns = 1.3;
  const double complete_high = raised * of_noise * result.floor;
  const double floor_high =
      std::min(complete_high, result.floor * std::max(of_noise, kMostOfUnknowns));
  result.worse_than_nominal = held_out.rows() > 0 && after > floor_high && after > nominal;
  result.all_from_few =
      held_out.rows() == 0 &&
      distinct_equations(*training.sound) < kEquationsOfUnknown * unknowns_of(result.trace.fit);
  for (size_t k = 0; k < result.gains.size() && result.unconfirmed_curve.empty(); ++k)
    if (const TracedEffect& traced = result.trace.effects[k];
        traced.in_words.empty() && !result.gains[k].confirmed())
      result.unconfirmed_curve = describe(traced.effect);
  result.verdict =
      conclude({.effects = result.trace.effects,
                .lack_of_fit = result.lack_of_fit,
                .knows_noise = result.noise.source != NoiseFloor::Source::none,
                .after = result.after_sound,
                .floor = result.floor,
                .floor_high = floor_high,
                .complete_high = complete_high,
                .outside_p = result.outside_p,
                .left_out_together = !result.left_out_together.empty(),
                .is_explained = !result.explanation.empty() || result.angles_read_early,
                .wanders = !result.wandering.empty(),
                .pattern_remains = result.trace.pattern_remains,
                .all_from_few = result.all_from_few,
                .unconfirmed_curve = !result.unconfirmed_curve.empty()});
  if (result.verdict == Verdict::too_few_poses)
    result.more_poses = result.all_from_few ? poses_to_hold_out(training, result)
                                            : poses_to_the_floor(result, floor_high);
}

// The best candidate that is not in the model.
void set_pattern(LoopResult& result) {
  if (result.rejected) {
    result.pattern = result.rejected->effects.front();
    result.trace.remaining_p = result.rejected->p_value;
  } else if (!result.trace.ranking.empty()) {
    result.pattern = describe(result.trace.ranking.front().effect);
  }
}

// Where readings have no time, no cause that follows time can be found. Its pattern shows in the
// order of the lines, which is no cause by itself: files are sorted, too. What random effects of
// the arm explain is not asked about.
void look_at_order(const Training& training, const Catalogue& catalogue,
                   const TraceOptions& options, LoopResult& result) {
  if (!training.sound->time_s.empty() || result.trace.pattern_remains || result.trace.left_out)
    return;
  Catalogue of_time;
  std::ranges::copy_if(catalogue, std::back_inserter(of_time), [](const CatalogueEntry& entry) {
    return entry.driver.kind == DriverKind::time && !entry.driver.factor;
  });
  TraceOptions scan = options;
  scan.start.clear();
  scan.beyond_catalogue = false;
  scan.max_effects = 0;
  // One more question is asked of the same readings.
  scan.significance = scan.significance_without_lack_of_fit;
  scan.flips *= 10;
  const TraceResult rest =
      trace(result.trace.fit.robot, in_order_of_visits(*training.sound), of_time, scan);
  if (!rest.pattern_remains || rest.ranking.empty()) return;
  const Effect& effect = rest.ranking.front().effect;
  result.trace.pattern_remains = true;
  result.trace.remaining_p = rest.remaining_p;
  result.pattern = fmt::format(
      "{} follows the order of the lines ({}); with the time of each reading (t_s) its "
      "cause can be searched",
      to_string(effect.parameter), to_string(effect.shape));
}

// The floor is that of the readings whose errors are reported.
void set_floor(const Training& training, const Campaign& held_out, LoopResult& result) {
  result.noise = training.quality.noise;
  result.lack_of_fit = training.quality.lack_of_fit;
  result.floor = mean_error(result.noise, held_out.rows() > 0 ? held_out : *training.sound);
}

void set_parts(LoopResult& result) {
  const auto mean_square = [](const Stage& stage) {
    return stage.training.position.rms * stage.training.position.rms;
  };
  const size_t last = result.stages.size() - (result.applied ? 2 : 1);
  const double taken = std::max(0.0, mean_square(result.stages[std::min<size_t>(1, last)]) -
                                         mean_square(result.stages[last]));
  for (const TracedEffect& traced : result.trace.effects)
    result.parts.push_back({describe(traced.effect), moves_program(traced.effect, false),
                            std::sqrt(taken * std::max(0.0, traced.variance_share.value))});
  if (!result.applied) return;
  for (const GroupShare& group : result.applied->groups)
    result.parts.push_back({group.name + ", without a name", group.of_arm, group.position});
}

}  // namespace

std::string describe(const Effect& effect) {
  return to_string(effect.parameter) + " follows " + to_string(effect.driver) + " (" +
         to_string(effect.shape) + ")";
}

LoopResult close_loop(const Robot& robot, const Campaign& given, const Campaign& all_held_out,
                      const Catalogue& catalogue, const TraceOptions& options,
                      bool angles_read_early) {
  require_known_sessions(given, all_held_out);
  LoopResult result;
  result.of_touches = given.has_touches();
  result.of_images = given.has_pixels_only();
  result.of_distances = given.reads_one_number() && !result.of_touches;
  result.training_poses = count_poses(given);
  result.rows = given.readings() + all_held_out.readings();
  JudgedTraining judged = judged_training(
      robot, given, all_held_out.rows() > 0 ? Then::predict : Then::report, catalogue, options);
  Training& training = judged.training;
  result.not_judged_rows =
      all_held_out.lines_of(rows_at_steps(training.trace, *training.sound, all_held_out));
  const Campaign judged_held_out = judged_readings(result, all_held_out);
  result.held_out_poses = count_poses(judged_held_out);
  set_excluded_rows(training, given, result);
  set_gross_held_out(training, judged_held_out, result);
  std::optional<Campaign> without_blunders;
  const Campaign& held_out =
      result.are_blunders
          ? without_blunders.emplace(without_gross(judged_held_out, result.gross_held_out))
          : judged_held_out;
  result.moved = something_moved(given, training);
  result.common_backlash = common_backlash(robot.chain, training.trace.effects);
  result.angles_read_early = angles_read_early || result.common_backlash;
  const bool geometry_alone = result.moved || result.angles_read_early;
  const bool has_effects = training.trace.stages.size() > 1;
  if (!geometry_alone) result.rejected = rejected_model(training.trace, held_out, options);
  const bool against_held = !result.rejected && is_against_held(training.trace, held_out, options);
  if (result.rejected || (geometry_alone && has_effects) || against_held)
    fall_back_to_geometry(judged);
  else
    leave_out_worse(judged, held_out, catalogue, options, result);
  if (!geometry_alone && (!judged.random.lasting.empty() || !judged.random.of_campaign.empty()))
    set_applied(judged, held_out, options, result);
  result.wandering = judged.wandering;
  result.trace = std::move(training.trace);
  result.gross_poses = std::move(training.gross_poses);
  for (size_t k = 0; k < training.errors.size(); ++k)
    result.stages.push_back(stage_of(k, training, result.trace.stages, judged_held_out));
  result.nominal = training.nominal;
  if (result.rejected) result.stages.back().name = "geometric, as the effects predict worse";
  if (against_held)
    result.stages.back().name = "geometric, as what priors alone hold predicts no better";
  if (result.moved && has_effects)
    result.stages.back().name = "geometric, as something moved among the images";
  if (result.angles_read_early && has_effects)
    result.stages.back().name = "geometric, as the angles were not read at standstill";
  if (result.applied) {
    Stage& stage = result.applied->stage;
    if (held_out.rows() > 0) stage.held_out = errors_of(result.applied->fit.robot, judged_held_out);
    result.stages.push_back(stage);
  }
  set_parts(result);
  set_excluded_rows(training, given, result);
  set_floor(training, held_out, result);

  const std::vector<Effect>& effects = result.trace.fit.robot.effects;
  const size_t declared = effects.size() - result.trace.effects.size();
  for (size_t k = 0; k < result.trace.effects.size(); ++k)
    result.curves.push_back(effect_curve(result.trace.fit, *training.sound, declared + k,
                                         result.trace.bootstrap_draws));
  result.held.assign(effects.begin() + robot.effects.size(), effects.begin() + declared);
  set_pattern(result);
  result.scale = unseen_scale(result.trace.fit.robot, *training.sound);
  if (result.wandering.empty())
    result.explanation = explanation_of_rest(result.trace.fit, *training.sound).value_or("");
  if (result.explanation.empty() && !result.rejected && !result.applied && !catalogue.empty())
    look_at_order(training, catalogue, options, result);
  if (held_out.rows() > 0) set_held_out(training, judged_held_out, held_out, options, result);
  set_verdict(training, held_out, result);
  return result;
}

Campaign judged_readings(const LoopResult& result, const Campaign& held_out) {
  std::vector<int> rows;
  for (int row = 0; row < held_out.rows(); ++row)
    if (std::ranges::binary_search(result.not_judged_rows, held_out.line[row])) rows.push_back(row);
  return without_rows(held_out, rows);
}

const CalibrationResult& result_of(const LoopResult& result) {
  return result.applied ? result.applied->fit : result.trace.fit;
}

FitToAll fit_to_all(const Robot& given, const LoopResult& result, const Campaign& all,
                    const Catalogue& catalogue) {
  const CalibrationResult& judged = result.trace.fit;
  // Geometry alone is that of calibrate(). Near a fit of few poses its law of readings would stay
  // as it was there, as would that of the two parts of readings among which something moved.
  const bool is_geometry =
      judged.robot.effects.size() == given.effects.size() && judged.set.by_small_angles.empty();
  const bool anew = result.moved || result.angles_read_early || is_geometry;
  FitToAll to_all{{}, find_gross_poses(anew ? given : judged.robot, all), all};
  if (!to_all.gross_poses.empty()) to_all.sound = without_gross(all, to_all.gross_poses);
  CalibrationOptions near;
  near.start_near(judged);
  to_all.fit = anew ? calibrate(given, to_all.sound)
                    : calibrate(judged.robot, to_all.sound, judged.set, near);
  if (!result.applied) return to_all;
  const bool instrument_errs = result.applied->instrument_errs;
  const CalibrationResult lawless =
      instrument_errs ? without_laws(to_all.fit, to_all.sound) : to_all.fit;
  const RandomEffects random = random_effects_beside(
      lawless, to_all.sound, instrument_errs ? &catalogue : nullptr, result.wandering);
  if (random.lasting.empty()) return to_all;
  CalibrationResult applied = applied_arm(lawless, to_all.sound, random);
  // Random effects hold as they were judged, or not at all.
  const auto mean = [&](const CalibrationResult& fit) {
    return errors_of(fit.robot, to_all.sound).position.mean;
  };
  if (mean(applied) <= kCountsAsWorse * mean(to_all.fit)) to_all.fit = std::move(applied);
  return to_all;
}

}  // namespace armtrue
