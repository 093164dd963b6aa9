#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/left_out.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/search/search.h"

namespace armtrue {

/// Another effect that this campaign cannot distinguish from a found effect, because it can imitate
/// most of its part in the readings.
struct Rival {
  Effect effect;
  double correlation = 0;  ///< cosine of the angle between the part of the found effect in the
                           ///< readings and its projection on the columns of the rival
  double delta_ebic = 0;   ///< by how much EBIC is higher with the rival in place of the effect
  /// The geometric parameters that change when the rival takes the place of the effect: those whose
  /// change moves the readings most.
  std::vector<std::string> refitted;
  std::string separated_by;  ///< measurement that separates it from similar effects, if known
  bool from_catalogue = false;
  /// It moves a link behind the last joint, to which the tool is fastened.
  bool is_behind_joints = false;
};

/// What an effect moves: the arm, the station (instrument, base, anchor, contact, beam, board,
/// camera) or what is fastened to the arm (tool, target).
enum class Moved { arm, station, fastened };
Moved moved_by(const Effect& effect);
/// A link behind the last joint counts as fastened: it turns as a tool turns in its mount.
Moved moved_by(const Rival& rival);

/// Whether a rival is another cause: one of the catalogue with another name or parameter, but not
/// one of the same name that follows the same driver of one joint. If both follow time, session or
/// temperature alone, any rival with another moved_by() is another cause, with or without a name: a
/// sinking stand moves readings as a growing column does. So is one that follows a temperature in
/// place of time, or the other way round, if the readings do not exclude it (odds below 20 to 1).
bool is_other_cause(const Effect& effect, const Rival& rival);

/// Whether a rival without a name could take the place of a named effect: the zero offset of
/// another joint follows the same driver, and the readings do not exclude it (odds below 20 to 1).
bool is_unlisted_cause(const KinematicChain& chain, const Effect& effect, const Rival& rival);

/// The figures by which an effect was added.
struct Evidence {
  /// Fall of EBIC (gamma 1) when the effect is added to all the others; positive is better. See
  /// ebic_fall().
  double delta_ebic = 0;
  double p_value = 1;  ///< family-wise, by sign-flips of the poses: share of draws whose best
                       ///< candidate scores as high
  double cross_validated_gain = 0;        ///< see CrossValidation::gain
  double cross_validated_gain_error = 0;  ///< its standard error
};

/// A harmonic A sin(n q + phase). Its frequency n is an unknown too, so it has an uncertainty.
struct Cycle {
  double amplitude = 0, amplitude_std = 0;  ///< [m, rad]
  std::array<double, 2> amplitude_ci95{0, 0};
  double phase = 0;  ///< [rad]
  /// [cycles per turn], clustered by pose; 0 if the frequency was given.
  double frequency_std = 0;
  std::array<double, 2> frequency_ci95{0, 0};  ///< Student's
};

/// Share of one effect in the fall of the sum of squares, from the geometry alone to all found
/// effects, averaged over the orders in which they may enter (see variance_shares). The shares of
/// all effects sum to 1.
struct VarianceShare {
  double value = 0;
  /// By Student's t, clustered by pose; takes the set of effects as given.
  std::array<double, 2> ci95{0, 0};
  /// Whether the effect could be the largest, given these poses: no other pair of parameter and
  /// driver explains significantly more (95 %) than the effects of its own pair.
  bool may_lead = false;
};

/// A found effect with its evidence.
struct TracedEffect {
  Effect effect;                 ///< with its coefficients
  std::optional<Cycle> cycle{};  ///< only of a harmonic
  /// Only of a step: the times of the readings between which it lies [s], 95 % by profile
  /// likelihood.
  std::optional<std::array<double, 2>> step_ci95{};
  Evidence evidence;
  VarianceShare variance_share;
  std::vector<Rival> indistinguishable;
  /// Effects that could imitate this one, but that these readings exclude by odds of more than 1000
  /// to 1: their EBIC is higher by more than 2 ln 1000.
  std::vector<Rival> ruled_out;
  std::string separated_by;  ///< as Rival::separated_by
  std::string in_words;      ///< as CatalogueEntry::in_words; empty where no cause is known
  /// Name of the cause under which the effect was found, if a curve without a name explains the
  /// readings so much better (odds of 1000 to 1, without the charge for the number of curves tried)
  /// that the cause is rejected. The effect is then named `unexplained`. Otherwise empty.
  std::string beaten_cause;
  bool from_catalogue = false;  ///< false: found by the open search, no cause is known
  bool incomplete = false;      ///< another effect has the same parameter and driver
  /// Of one that these readings show only together with other members of its family: these members,
  /// which stay in the model by their common prior. Then `evidence` is that of all of them.
  std::vector<Effect> shared_with;
};

/// Whether the effect may be an error of the instrument and not of the arm. This is so if
/// - an error of the instrument is indistinguishable from it;
/// - no cause is known and the base or a length follows an angle of a joint, or a length has a step
///   in time: no rigid arm does that;
/// - no cause is known and it follows the payload alone, and so could the tool, a target or a link
///   behind the last joint, which may sit elsewhere under another load;
/// - it follows time or session alone and moves neither instrument nor base, while an effect of
///   `robot` moves one of these by time or session: no law describes such an event exactly, and its
///   residual follows time too. Evidence of 1000 to 1 (2 ln 1000 of EBIC) rules this out.
bool may_be_instrument(const TracedEffect& traced, const Robot& robot);

/// The result of trace().
struct TraceResult {
  CalibrationResult fit;                  ///< the model with all effects, on the readings given
  std::vector<CalibrationResult> stages;  ///< geometry alone, then with each effect as it was added
  std::vector<TracedEffect> effects;
  Eigen::MatrixXd bootstrap_draws;       ///< draws x coefficients; see bootstrap_coefficients()
  std::vector<RankedCandidate> ranking;  ///< of the last scan, best first
  /// Effects of the catalogue that no campaign like this can show: parameters of the geometry
  /// imitate them completely.
  std::vector<RankedCandidate> not_separable;
  double best_score = 0;  ///< of the last scan; 0 or less if nothing is left to explain
  NullRun null_run;
  double remaining_p = 1;  ///< family-wise p-value of the best candidate that was not added
  /// Whether that p is below the level for adding an effect: only another criterion kept the
  /// candidate out.
  bool pattern_remains = false;
  /// Parameters that the robot file does not let a fit identify, though the readings show them.
  /// Then no effect is found, because it would take their place; LeftOut::beside has those that are
  /// found beside all parameters.
  std::optional<LeftOut> left_out{};
};

/// Finds the effects that the model lacks, one by one. Each step scores all candidates (the
/// catalogue, then parameter x driver x shape) on the residual, projected off everything already in
/// the model. It adds the best candidate if EBIC falls, its family-wise p under sign-flips is below
/// the significance, the cross-validated gain exceeds its standard error and its size is physically
/// possible. After each addition everything is refitted jointly, and effects are dropped or
/// exchanged where that lowers EBIC. The search uses at most 2000 poses, drawn evenly from each
/// session, and 50 readings of each, drawn evenly from its visits, or 5000 in all if that is more;
/// the final fit uses all. Evidence and frequencies come from the readings of the search. All
/// sessions share the effects. The base and the zero offsets of each session are in the model from
/// the start, so that no effect imitates them. Standard deviations of the coefficients are those of
/// calibrate(); the cluster bootstrap by pose gives the asymmetry of their intervals.
TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options = {});

}  // namespace armtrue
