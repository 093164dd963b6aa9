#include "armtrue/search/training.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>

#include "armtrue/calibration/pose_bootstrap.h"
#include "armtrue/calibration/prediction.h"
#include "armtrue/calibration/refit.h"
#include "armtrue/calibration/worthwhile.h"
#include "armtrue/campaign/without_rows.h"
#include "armtrue/observation/session_models.h"
#include "linear_algebra/decompositions.h"
#include "search/evidence.h"

namespace armtrue {
namespace {

// Searches without the gross poses. Effects that the geometry lacks may hide a gross pose, or look
// like one. So gross poses are searched again when the effects are known.
Training trace_sound(const Robot& robot, const Campaign& given, const Catalogue& catalogue,
                     const TraceOptions& options) {
  Training training;
  const auto trace_without = [&](std::vector<GrossPose> gross) {
    training.without_gross =
        gross.empty() ? nullptr : std::make_unique<const Campaign>(without_gross(given, gross));
    training.sound = gross.empty() ? &given : training.without_gross.get();
    training.gross_poses = std::move(gross);
    training.trace = trace(robot, *training.sound, catalogue, options);
  };
  trace_without(find_gross_poses(robot, given));
  if (training.trace.effects.empty()) return training;
  std::vector<GrossPose> gross = find_gross_poses(training.trace.fit.robot, given);
  if (rows_of(gross) != rows_of(training.gross_poses)) trace_without(std::move(gross));
  return training;
}

// Without some of its effects, a fit to first order: with the inverse S = L L^T of its information
// and L_k the rows of the coefficients x_k of these effects, the least squares under x_k = 0 is
//     x - S_k S_kk^-1 x_k = x - L y,    y = L_k^+ x_k,
// and the loss is higher by |y|^2.
struct WithoutEffects {
  Robot robot;
  double rise;  ///< of the loss
};

WithoutEffects without_effects(const CalibrationResult& fit, const SessionModels& models,
                               const std::vector<size_t>& descending) {
  std::vector<Eigen::Index> first{models.geometric_count()};  // coefficient of each effect
  for (const Effect& effect : fit.robot.effects)
    first.push_back(first.back() + std::ssize(effect.coefficients));
  std::vector<Eigen::Index> dropped;
  for (size_t effect : descending)
    for (Eigen::Index k = first[effect]; k < first[effect + 1]; ++k) dropped.push_back(k);
  Eigen::VectorXd value(std::ssize(dropped));
  for (Eigen::Index k = 0; size_t effect : descending)
    for (const Coefficient& coefficient : fit.robot.effects[effect].coefficients)
      value[k++] = coefficient.value;
  const Eigen::MatrixXd own = fit.inverse_root(dropped, Eigen::all);
  const Eigen::VectorXd y = own.completeOrthogonalDecomposition().solve(value);
  WithoutEffects without{models.robot_at(-fit.inverse_root * y), y.squaredNorm()};
  for (size_t effect : descending)
    without.robot.effects.erase(without.robot.effects.begin() + effect);
  return without;
}

// The fit without one effect, all else adjusted to that. Among the held effects, those from `held`
// to `found`, the members of its family that share it go, too, and with an error of the instrument
// its distortion. Where the readings do not fit much worse, their law stays as it is, and the fit
// is linear.
Robot without_effect(const CalibrationResult& fit, const SessionModels& models, size_t held,
                     size_t found, const TracedEffect& traced, size_t effect) {
  std::vector<size_t> dropped{effect};
  for (size_t k = found; k-- > held;) {
    const Effect& other = fit.robot.effects[k];
    const auto is_it = [&](const Effect& member) { return same_form(member, other); };
    if ((is_of_instrument(fit.robot.effects[effect]) && is_polynomial(other.shape)) ||
        std::ranges::any_of(traced.shared_with, is_it))
      dropped.push_back(k);
  }
  const WithoutEffects linear = without_effects(fit, models, dropped);
  constexpr double kSameLaw = 0.1;  // of the loss: sigma changes by 5 %
  const double equations = models.rows() * models.row_size();
  if (linear.rise < kSameLaw * equations) return linear.robot;
  constexpr double kTolerance = 1e-5;  // an error to three digits is all that is asked of it
  return refit(linear.robot, models.campaign(), fit, kTolerance).robot;
}

std::vector<PoseErrors> errors_of_stages(const Training& training) {
  std::vector<PoseErrors> errors{training_errors(training.nominal, training)};
  for (const CalibrationResult& stage : training.trace.stages)
    errors.push_back(training_errors(stage.robot, training));
  return errors;
}

}  // namespace

PoseErrors training_errors(const Robot& robot, const Training& training) {
  const std::vector<int>& blunders = training.quality.blunders;
  if (blunders.empty()) return errors_of(robot, *training.sound);
  return errors_of(robot, without_rows(*training.sound, blunders));
}

void fall_back_to_geometry(Training& training) {
  TraceResult& trace = training.trace;
  trace.fit = trace.stages.front();
  trace.stages.push_back(trace.fit);
  trace.effects.clear();
  trace.pattern_remains = false;
  trace.bootstrap_draws.resize(0, 0);
  training.quality = assess(trace.fit, *training.sound);
  training.errors = errors_of_stages(training);
  training.without_effect.clear();
  if (training.if_complete)
    training.if_complete = uncertainty_if_complete(trace.fit, *training.sound);
}

namespace {

// What predictions of held-out poses need, of the last model.
void set_predictions(Training& training) {
  const CalibrationResult& fit = training.trace.fit;
  const Campaign& sound = *training.sound;
  const size_t effects = fit.robot.effects.size();
  const size_t found = effects - training.trace.effects.size();
  const size_t declared = training.trace.stages.front().robot.effects.size();
  const SessionModels models(sound, fit.robot, fit.set.kept, fit.sigma);
  training.without_effect.clear();
  for (size_t k = found; k < effects; ++k)
    training.without_effect.push_back(
        without_effect(fit, models, declared, found, training.trace.effects[k - found], k));
  training.if_complete = uncertainty_if_complete(fit, sound);
}

}  // namespace

void leave_out_effect(Training& training, size_t k, const TraceOptions& options) {
  TraceResult& trace = training.trace;
  const Campaign& sound = *training.sound;
  Robot robot = trace.fit.robot;
  const size_t first = robot.effects.size() - trace.effects.size();
  robot.effects.erase(robot.effects.begin() + static_cast<std::ptrdiff_t>(first + k));
  trace.effects.erase(trace.effects.begin() + static_cast<std::ptrdiff_t>(k));
  CalibrationOptions near;
  near.start_near(trace.fit);
  CalibrationResult fit = calibrate(robot, sound, trace.fit.set, near);
  trace.fit = std::move(fit);
  trace.bootstrap_draws = bootstrap_coefficients(trace.fit, sound, options.bootstrap, options.seed);
  set_intervals(trace.bootstrap_draws, static_cast<int>(sound.pose_ids.size()), trace.fit.robot);
  for (size_t other = 0; other < trace.effects.size(); ++other)
    trace.effects[other].effect.coefficients = trace.fit.robot.effects[first + other].coefficients;
  trace.stages.push_back(trace.fit);
  training.quality = assess(trace.fit, sound);
  training.errors = errors_of_stages(training);
  set_predictions(training);
}

Training search_training(const Robot& robot, const Campaign& given, Then then,
                         const Catalogue& catalogue, const TraceOptions& options) {
  Training training = trace_sound(robot, given, catalogue, options);
  const Campaign& sound = *training.sound;
  const CalibrationResult& fit = training.trace.fit;
  training.nominal = placed_nominal(robot, sound);
  training.quality = assess(fit, sound);
  training.errors = errors_of_stages(training);
  require_worthwhile(robot, fit, sound, training.quality.blunders, given.rows() - sound.rows());
  if (then == Then::predict) set_predictions(training);
  return training;
}

}  // namespace armtrue
