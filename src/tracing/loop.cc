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
#include "tracing/held_out.h"
#include "tracing/joint_curves.h"
#include "tracing/judged_names.h"
#include "tracing/rows_at_steps.h"

namespace armtrue {
namespace {

int count_poses(const Campaign& campaign) {
  return static_cast<int>(std::set<int>(campaign.pose.begin(), campaign.pose.end()).size());
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

// The sequence of models, the applied arm last. `why_geometry`: why the last one of the search is
// the geometry again; or empty.
void set_stages(const Training& training, const Campaign& held_out, const std::string& why_geometry,
                LoopResult& result) {
  for (size_t k = 0; k < training.errors.size(); ++k)
    result.stages.push_back(stage_of(k, training, result.trace.stages, held_out));
  if (!why_geometry.empty()) result.stages.back().name = "geometric, as " + why_geometry;
  if (!result.applied) return;
  Stage& stage = result.applied->stage;
  if (held_out.rows() > 0) stage.held_out = errors_of(result.applied->fit.robot, held_out);
  result.stages.push_back(stage);
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

// Errors before and after on the held-out poses, and the held-out gain of each effect.
// Errors count all of `held_out`, gains those that are `sound`.
void set_held_out(const Training& training, const Campaign& held_out, const Campaign& sound,
                  const TraceOptions& options, LoopResult& result) {
  result.errors_before = evaluate(result.trace.stages.front().robot, held_out).reading_errors();
  const std::vector<double> named = evaluate(result.trace.fit.robot, held_out).reading_errors();
  result.after_named = summarize(named).mean;
  if (const auto alone = arm_alone(result_of(result).robot, *training.sound))
    result.after_arm = mean_reading_error(*alone, held_out);
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
  result.removed_ci95 = removed_ci95(result, poses_of_readings(held_out), options);
  result.gain_ci95 = gain_of(result.errors_before, result.errors_after, held_out, options).ci95;
  const std::vector<double> with = evaluate(result.trace.fit.robot, sound).reading_errors();
  for (const Robot& without : training.without_effect)
    result.gains.push_back(
        gain_of(evaluate(without, sound).reading_errors(), with, sound, options));
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

// Why the result is the geometry, though there are effects; empty if it is not, or if there are
// none. Sets `result.rejected`.
std::string why_geometry_alone(const TraceResult& trace, const Campaign& held_out,
                               const TraceOptions& options, LoopResult& result) {
  if (trace.stages.size() == 1) return "";
  if (result.angles_read_early) return "the angles were not read at standstill";
  if (result.moved) return "something moved among the images";
  result.rejected = rejected_model(trace, held_out, options);
  if (result.rejected) return "the effects predict worse";
  if (is_against_held(trace, held_out, options)) return "what priors alone hold predicts no better";
  return "";
}

// Sets the applied arm, unless held-out poses speak against random effects.
void set_applied(const JudgedTraining& judged, const Campaign& held_out,
                 const TraceOptions& options, LoopResult& result) {
  const RandomEffects& random = judged.random;
  if (random.lasting.empty() && random.of_campaign.empty()) return;
  const Campaign timed = in_order_of_visits(*judged.training.sound);
  CalibrationResult all = beside(
      judged.instrument_errs ? without_laws(judged.training.trace.fit, *judged.training.sound)
                             : judged.training.trace.fit,
      timed, random);
  if (!random.of_campaign.empty() && held_out.rows() > 0 && held_out.source == timed.source)
    result.after_readings = mean_reading_error(all.robot, in_order_of_visits(held_out));
  if (random.lasting.empty()) return;
  AppliedArm applied{
      without_campaign(std::move(all), timed, random), {}, random.groups, judged.instrument_errs};
  const Robot& robot = applied.fit.robot;
  if (held_out.rows() > 0 && !speak_for(robot, judged, held_out, options)) return;
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
    result.after_sound = mean_reading_error(result.trace.fit.robot, sound);
    after = mean_reading_error(result_of(result).robot, held_out);
    nominal = mean_reading_error(result.nominal, held_out);
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

void set_counts(const Campaign& training, const Campaign& held_out, LoopResult& result) {
  result.of_touches = training.has_touches();
  result.of_images = training.has_pixels_only();
  result.of_distances = training.reads_one_number() && !result.of_touches;
  result.training_poses = count_poses(training);
  result.rows = training.readings() + held_out.readings();
}

// The curves of found effects, and the effects that a prior alone holds. `given`: the robot that
// was.
void set_effects(const Robot& given, const Campaign& training, LoopResult& result) {
  const std::vector<Effect>& effects = result.trace.fit.robot.effects;
  const size_t first = effects.size() - result.trace.effects.size();
  for (size_t k = first; k < effects.size(); ++k)
    result.curves.push_back(
        effect_curve(result.trace.fit, training, k, result.trace.bootstrap_draws));
  result.held.assign(effects.begin() + given.effects.size(), effects.begin() + first);
}

}  // namespace

LoopResult close_loop(const Robot& robot, const Campaign& given, const Campaign& all_held_out,
                      const Catalogue& catalogue, const TraceOptions& options,
                      bool angles_read_early) {
  require_known_sessions(given, all_held_out);
  LoopResult result;
  set_counts(given, all_held_out, result);
  JudgedTraining judged = judged_training(
      robot, given, all_held_out.rows() > 0 ? Then::predict : Then::report, catalogue, options);
  Training& training = judged.training;
  result.not_judged_rows =
      all_held_out.lines_of(rows_at_steps(training.trace, *training.sound, all_held_out));
  const Campaign judged_held_out = judged_readings(result, all_held_out);
  result.held_out_poses = count_poses(judged_held_out);
  set_excluded_rows(training, given, result);
  set_gross_held_out(training, judged_held_out, result);
  const Campaign held_out =
      result.are_blunders ? without_gross(judged_held_out, result.gross_held_out) : judged_held_out;
  result.moved = something_moved(given, training);
  result.common_backlash = common_backlash(robot.chain, training.trace.effects);
  result.angles_read_early = angles_read_early || result.common_backlash;

  const std::string why_geometry = why_geometry_alone(training.trace, held_out, options, result);
  if (why_geometry.empty())
    result.without_gain = leave_out_worse(judged, held_out, catalogue, options);
  else
    fall_back_to_geometry(judged);
  if (!result.moved && !result.angles_read_early) set_applied(judged, held_out, options, result);
  result.wandering = judged.wandering;
  result.trace = std::move(training.trace);
  result.gross_poses = std::move(training.gross_poses);
  result.nominal = training.nominal;
  set_excluded_rows(training, given, result);
  set_stages(training, judged_held_out, why_geometry, result);
  set_parts(result);
  set_floor(training, held_out, result);
  set_effects(robot, *training.sound, result);

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

}  // namespace armtrue
