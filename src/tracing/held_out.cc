#include "tracing/held_out.h"

#include <algorithm>
#include <limits>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/pose_bootstrap.h"

namespace armtrue {
namespace {

std::vector<double> errors_on(const Campaign& held_out, const Robot& robot) {
  return evaluate(robot, held_out).reading_errors();
}

double standard_error(const HeldOutGain& gain) {
  constexpr double kErrorsIn95 = 3.92;
  return (gain.ci95[1] - gain.ci95[0]) / kErrorsIn95;
}

bool is_better(const HeldOutGain& gain) { return gain.position > standard_error(gain); }

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
  const std::vector<double> with = errors_on(held_out, model);
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
    const HeldOutGain gain = gain_of(errors_on(held_out, without), with, held_out, options);
    if (is_supported(traced, gain, options) || gain.position >= least ||
        turn(without) > turn(model))
      continue;
    least = gain.position;
    worst = k;
  }
  return worst;
}

}  // namespace

std::vector<int> poses_of_readings(const Campaign& campaign) {
  const std::vector<int> poses = campaign.pose_by_id(), first = campaign.first_rows_of_readings();
  if (first.empty()) return poses;
  std::vector<int> of_readings;
  for (int row : first) of_readings.push_back(poses[row]);
  return of_readings;
}

HeldOutGain gain_of(const std::vector<double>& without, const std::vector<double>& with,
                    const Campaign& held_out, const TraceOptions& options) {
  const auto pose = poses_of_readings(held_out);
  const int poses = 1 + *std::max_element(pose.begin(), pose.end());
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(poses, 2);  // sum of differences, readings
  for (size_t k = 0; k < with.size(); ++k)
    by_pose.row(pose[k]) += Eigen::RowVector2d(without[k] - with[k], 1);
  const Eigen::MatrixXd sums = drawn_sums(by_pose, options.bootstrap, options.seed);
  const Eigen::VectorXd means = sums.col(0).cwiseQuotient(sums.col(1));
  return {summarize(without).mean - summarize(with).mean,
          percentile_interval({means.begin(), means.end()}, poses)};
}

std::optional<RejectedModel> rejected_model(const TraceResult& trace, const Campaign& held_out,
                                            const TraceOptions& options) {
  const std::vector<Effect>& effects = trace.fit.robot.effects;
  const size_t declared = trace.stages.front().robot.effects.size();
  if (effects.size() == declared || held_out.rows() == 0) return std::nullopt;
  const std::vector<double> without = errors_on(held_out, trace.stages.front().robot);
  const std::vector<double> with = errors_on(held_out, trace.fit.robot);
  const HeldOutGain gain = gain_of(without, with, held_out, options);
  const double after = summarize(with).mean;
  const bool is_worse =
      gain.position < -standard_error(gain) && after > kCountsAsWorse * summarize(without).mean;
  if (!is_worse) return std::nullopt;
  RejectedModel rejected{{}, after, gain.ci95};
  if (!trace.effects.empty()) rejected.p_value = trace.effects.front().evidence.p_value;
  for (const TracedEffect& traced : trace.effects)
    rejected.effects.push_back(describe(traced.effect));
  for (size_t k = declared; k < effects.size() - trace.effects.size(); ++k)
    rejected.effects.push_back(describe(effects[k]));
  return rejected;
}

bool is_against_held(const TraceResult& trace, const Campaign& held_out,
                     const TraceOptions& options) {
  const bool has_held =
      std::ssize(trace.fit.robot.effects) > std::ssize(trace.stages.front().robot.effects);
  if (!has_held || !trace.effects.empty() || held_out.rows() == 0) return false;
  return !is_better(gain_of(errors_on(held_out, trace.stages.front().robot),
                            errors_on(held_out, trace.fit.robot), held_out, options));
}

std::vector<std::string> leave_out_worse(JudgedTraining& judged, const Campaign& held_out,
                                         const Catalogue& catalogue, const TraceOptions& options) {
  std::vector<std::string> left_out;
  if (held_out.rows() == 0) return left_out;
  Training& training = judged.training;
  const Campaign& sound = *training.sound;
  while (const std::optional<size_t> worst = worst_effect(training, held_out, options)) {
    left_out.push_back(describe(training.trace.effects[*worst].effect));
    leave_out_effect(training, *worst, options);
  }
  if (left_out.empty()) return left_out;
  const CalibrationResult& fit = training.trace.fit;
  judged.random =
      judged.instrument_errs
          ? random_effects_beside(without_laws(fit, sound), sound, &catalogue, judged.wandering)
          : random_effects_beside(fit, sound, nullptr, judged.wandering);
  return left_out;
}

bool speak_for(const Robot& applied, const JudgedTraining& judged, const Campaign& held_out,
               const TraceOptions& options) {
  const std::vector<double> before = errors_on(held_out, judged.training.trace.fit.robot),
                            after = errors_on(held_out, applied);
  if (judged.instrument_errs)
    return summarize(after).mean <= kCountsAsWorse * summarize(before).mean;
  const HeldOutGain gain = gain_of(before, after, held_out, options);
  return judged.random.joints_err ? is_better(gain) : gain.position >= 0;
}

}  // namespace armtrue
