#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/calibration/gross_poses.h"
#include "armtrue/calibration/unseen_scale.h"
#include "armtrue/search/trace.h"
#include "armtrue/tracing/effect_curve.h"
#include "armtrue/tracing/nested_validation.h"
#include "armtrue/tracing/verdict.h"

namespace armtrue {

/// A mean error counts as worse if it is higher by this factor.
inline constexpr double kCountsAsWorse = 1.05;

/// One model of the sequence from the nominal robot to the final one.
struct Stage {
  std::string name;
  int parameters = 0;
  PoseErrors training, held_out;
};

/// By how much an effect lowers the error of held-out poses. Confirmed: the whole interval is above
/// zero. Denied: it is below.
struct HeldOutGain {
  bool confirmed() const { return ci95[0] > 0; }
  bool denied() const { return ci95[1] < 0; }
  double position = 0;               ///< mean error without the effect minus mean error with it [m]
  std::array<double, 2> ci95{0, 0};  ///< paired bootstrap over poses [m]
};

/// Effects that are no part of the result, because held-out poses are clearly predicted worse with
/// them than by the geometry alone.
struct RejectedModel {
  /// describe() of each: found effects, largest share first, then those that only a prior held.
  std::vector<std::string> effects;
  double after = 0;                  ///< mean held-out position error with them [m]
  std::array<double, 2> gain_ci95{0, 0};  ///< of geometry minus model; both below zero [m]
  double p_value = 1;                     ///< of the first effect that was found
};

/// Size of one group of random effects in the readings of the training poses.
struct GroupShare {
  std::string name;     ///< in words: "gravity", "curves of the joints"
  bool of_arm = true;   ///< else of the station
  double of_noise = 0;  ///< RMS, in standard deviations of the noise of the readings
  double position = 0;  ///< RMS motion of positions [m]
};

/// Part of one cause, or of one group of random effects, in the training readings.
struct Part {
  std::string what;     ///< in words
  bool of_arm = true;   ///< programs are corrected for it; else of the station
  double position = 0;  ///< RMS [m]
};

/// The arm as it is applied: the model, with the posterior mean of the random effects of the arm,
/// which have no name. None of these is a finding.
struct AppliedArm {
  CalibrationResult fit;  ///< its effects: those of the model, then those without a name
  Stage stage;
  std::vector<GroupShare> groups;
  bool instrument_errs = false;  ///< by random effects beside its laws; see errors_of_instrument()
};

/// The held-out reading with the largest position error of the final model.
struct WorstReading {
  std::string pose;
  double error = 0;  ///< [m]
};

/// The result of close_loop().
struct LoopResult {
  Verdict verdict = Verdict::unexplained;
  bool of_distances = false;  ///< position errors are those of distances
  bool of_touches = false;    ///< position errors are those of touches
  bool of_images = false;     ///< all readings are pixels
  NoiseFloor noise;
  int training_poses = 0, rows = 0;
  int held_out_poses = 0;  ///< with readings that are judged
  /// Lines of the training file that the final fit counts as blunders; includes those of gross
  /// poses.
  std::vector<int> excluded_rows;
  std::vector<GrossPose> gross_poses;  ///< among the training poses; no fit uses them
  /// See find_gross_held_out(); errors count them.
  std::vector<GrossPose> gross_held_out;
  /// Whether training poses are blunders, too, and no less often: then the choices and the verdict
  /// do without `gross_held_out`.
  bool are_blunders = false;
  std::string left_out_together;       ///< see left_out_together()
  std::string explanation;             ///< see explanation_of_rest()
  std::string wrong_readings;          ///< see Findings; then nothing is explained
  /// Whether the joint angles were read before the arm stood, as the diagnosis says or as the
  /// effects that were found show (`common_backlash`): the result is the geometry.
  bool angles_read_early = false;
  std::optional<double> common_backlash;  ///< of the effects that were found
  Robot nominal;  ///< with base and tool fitted to the training readings: that of the first stage
  std::vector<Stage> stages;
  /// Whether a camera or a board moved among the images: the result is the geometry.
  bool moved = false;
  std::optional<RejectedModel> rejected;  ///< the last stage is the geometry again
  /// describe() of each found effect that is no part of the result, because held-out poses deny it;
  /// see HeldOutGain.
  std::vector<std::string> without_gain;
  /// describe() of a found curve of no listed cause whose gain held-out poses do not confirm;
  /// empty: none.
  std::string unconfirmed_curve;
  /// Parameters of the arm that change again and again in time, as by friction that remembers: no
  /// event, and none of the result.
  std::vector<Parameter> wandering;
  TraceResult trace;
  std::vector<double> errors_before, errors_after;  ///< of each held-out reading [m]
  /// Lines of held-out readings that the others of their pose contradict. Errors count them; the
  /// verdict does not.
  std::vector<int> contradicted_rows;
  /// As `after_named`, without them and without `gross_held_out` if `are_blunders` [m].
  double after_sound = 0;
  /// Lines of held-out readings at a step in time: between the training readings between which it
  /// lies. They may be of either side, so nothing counts them.
  std::vector<int> not_judged_rows;
  std::optional<WorstReading> worst;                ///< of those held out
  std::vector<HeldOutGain> gains;                   ///< per effect of the trace
  std::vector<std::vector<CurvePoint>> curves;      ///< per effect of the trace; see effect_curve
  std::vector<Effect> held;  ///< members of families without evidence of their own: only the prior
                             ///< keeps them in the model
  /// Whether no pose is held out and there are fewer than two equations for each unknown: what is
  /// left of them says nothing of other poses.
  bool all_from_few = false;
  /// With `too_few_poses`: number of additional poses that would bring the error to the floor.
  int more_poses = 0;
  /// p of the number of held-out poses beyond their 95 % bounds; see p_of_errors().
  double outside_p = 1;
  double before = 0, after = 0;  ///< mean held-out position error, geometric and as applied [m]
  double after_named = 0;        ///< that of the model of `trace` [m]
  /// That of the arm alone, as it corrects programs: without what station and tool do, base and
  /// tool placed anew on the training poses. Errors of wires are taken off the readings. Nothing if
  /// the station and tool have no effect [m].
  std::optional<double> after_arm;
  /// That of the model with the random effects of this campaign, too: time or order of visits,
  /// temperature, the way to a pose. It says how much of the readings is understood; no program can
  /// follow it. Nothing without such effects, if it is not below `after`, or if the held-out poses
  /// are not of the same file [m].
  std::optional<double> after_readings;
  double floor = 0;              ///< mean error of a perfect model [m]
  double reducible_removed = 0;  ///< (before^2 - after^2) / (before^2 - floor^2), in [0, 1]
  std::array<double, 2> removed_ci95{0, 0};  ///< of it, bootstrap over poses and floor
  /// The held-out error is above that of the nominal robot with base and tool fitted, and above
  /// what noise explains.
  bool worse_than_nominal = false;
  std::array<double, 2> gain_ci95{0, 0};   ///< of before - after, paired bootstrap over poses [m]
  std::optional<double> lack_of_fit;       ///< p, of the final model on the training poses
  std::optional<NestedValidation> nested;  ///< close_loop leaves it empty
  /// Empty if no random effect is worth applying, or if held-out poses are predicted worse with
  /// them: then the model of `trace` is applied.
  std::optional<AppliedArm> applied;
  /// Named effects, then groups of `applied`. Effects divide, by their shares, the mean square that
  /// all named ones take off.
  std::vector<Part> parts;
  std::vector<JointCurve> joints;          ///< of `applied`; see joint_curves()
  std::optional<UnseenScale> scale;        ///< at the training poses
  std::string pattern;                     ///< the best remaining candidate, in words
};

/// The loop: geometry, tracing and refit on `training` alone. `held_out` is used once, to report,
/// and for one choice: where the mean error rises by more than 5 % and by a standard error with all
/// effects together, the result is the geometry; a found effect that held-out poses deny is left
/// out, unless it is one of a family, which has its evidence together, or is_undecided(); a weak
/// one (p above TraceOptions::significance_without_lack_of_fit) that they do not support is; and
/// random effects are applied only where the mean error does not rise (by 5 % at most where
/// AppliedArm::instrument_errs). With `angles_read_early` (Findings::early_angles), or if the found
/// effects are one backlash of the joints (common_backlash()), the result is the geometry: any
/// effect would follow what the angles err by. Throws std::invalid_argument if a
/// session of `held_out` has no reading in `training`.
LoopResult close_loop(const Robot& robot, const Campaign& training, const Campaign& held_out,
                      const Catalogue& catalogue, const TraceOptions& options = {},
                      bool angles_read_early = false);

/// The held-out readings without LoopResult::not_judged_rows.
Campaign judged_readings(const LoopResult& result, const Campaign& held_out);

/// The robot that is the result: that of `applied`, else that of the trace.
const CalibrationResult& result_of(const LoopResult& result);

/// The robot that is the result, fitted to all poses that were measured.
struct FitToAll {
  CalibrationResult fit;
  std::vector<GrossPose> gross_poses;  ///< among all poses; the fit does not use them
  Campaign sound;                      ///< all readings but theirs
};

/// Fits the judged model, with its random effects, to all poses: training and held-out ones. More
/// poses make the same model more exact. `given`: the robot of close_loop(); where
/// LoopResult::moved, it is calibrated by calibrate().
FitToAll fit_to_all(const Robot& given, const LoopResult& result, const Campaign& all,
                    const Catalogue& catalogue);

/// "A5.theta follows joint-angle 4 (series)".
std::string describe(const Effect& effect);

}  // namespace armtrue
