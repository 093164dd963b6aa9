#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/search/search.h"

namespace armtrue {

/// Something that this campaign cannot tell from an effect that was found: it can imitate most of
/// what the effect does.
struct Rival {
  Effect effect;
  double correlation = 0;  ///< of what the found effect does with the closest that it can do
  double delta_ebic = 0;   ///< how much worse it explains the readings
  /// What is refitted when it takes the effect's place: the geometric parameters that move most, by
  /// what their change does to the readings.
  std::vector<std::string> refitted;
  std::string separated_by;  ///< what to measure to tell it from its likes; empty if not known
  bool from_catalogue = false;
};

/// Why an effect was added.
struct Evidence {
  /// Fall of EBIC (gamma 1) when it is added to all the others; positive is better. It counts the
  /// dimensions that the residual has, and a coefficient is charged as under the prior width that
  /// suits the effect, at most the ln n of BIC.
  double delta_ebic = 0;
  double p_value = 1;               ///< family-wise, of the best candidate under sign-flips by pose
  double cross_validated_gain = 0;  ///< share of the mean squared whitened residual
  double cross_validated_gain_error = 0;  ///< its standard error
};

/// A harmonic A sin(n q + phase), its frequency n as uncertain as the rest.
struct Cycle {
  double amplitude = 0, amplitude_std = 0;  ///< [m, rad]
  std::array<double, 2> amplitude_ci95{0, 0};
  double phase = 0;  ///< [rad]
  /// [cycles per turn], clustered by pose; 0 if it was not searched.
  double frequency_std = 0;
  std::array<double, 2> frequency_ci95{0, 0};  ///< Student's
};

/// Of what the effects explain together of the residual of the geometry, averaged over the orders
/// in which they may enter (see variance_shares); the effects' shares sum to 1.
struct VarianceShare {
  double value = 0;
  /// Student's, clustered by pose, given the effects that are named.
  std::array<double, 2> ci95{0, 0};
  /// Whether no other parameter and driver explain clearly more (95 %) than its own altogether.
  bool may_lead = false;
};

struct TracedEffect {
  Effect effect;                 ///< with its coefficients
  std::optional<Cycle> cycle{};  ///< of a harmonic
  /// Of a step: the readings between which it lies [s], 95 % by profile likelihood.
  std::optional<std::array<double, 2>> step_ci95{};
  Evidence evidence;
  VarianceShare variance_share;
  std::vector<Rival> indistinguishable;
  /// Those that could imitate it by their course, but that these readings speak against by odds of
  /// more than a thousand to one.
  std::vector<Rival> ruled_out;
  std::string separated_by;  ///< as of a rival
  std::string in_words;      ///< as of CatalogueEntry; empty where no cause is known
  /// The cause that it was found as, where a curve without a name explains the readings so much
  /// better that the cause does not stand: odds of a thousand to one, the price of having looked at
  /// many not counted. The effect is then unexplained.
  std::string beaten_cause;
  bool from_catalogue = false;  ///< false: found by the open search, no cause is known
  bool incomplete = false;      ///< its parameter follows its driver in a further effect too
};

/// Whether the readings leave open that the instrument errs in place of the arm: one of its errors
/// is indistinguishable from the effect, or without a known cause the base or a length follows a
/// joint angle, or a length jumps in time, which no rigid arm does.
bool may_be_instrument(const TracedEffect& traced, const Robot& robot);

struct TraceResult {
  CalibrationResult fit;                  ///< the model with all effects, on the readings given
  std::vector<CalibrationResult> stages;  ///< geometry alone, then with each effect as it was added
  std::vector<TracedEffect> effects;
  Eigen::MatrixXd bootstrap_draws;       ///< draws x coefficients; see bootstrap_coefficients()
  std::vector<RankedCandidate> ranking;  ///< of the last scan, best first
  /// Catalogue effects that no campaign like this can show.
  std::vector<RankedCandidate> not_separable;
  double best_score = 0;  ///< of the last scan; not positive if nothing is left to explain
  NullRun null_run;
  double remaining_p = 1;  ///< family-wise p-value of the best candidate that was not added
};

/// Finds the effects that the model lacks, one by one: scan of the catalogue, and of what lies
/// beyond it, on the residual projected off everything already in the model; the best is added if
/// EBIC falls, its family-wise p under sign-flips is below the significance, the cross-validated
/// gain exceeds its standard error and its size is physically possible. After every addition all is
/// refitted jointly, and effects are dropped or exchanged where that lowers EBIC.
/// Of more than 2000 poses as many, evenly taken in each session, are searched, and the model is
/// fitted to all; the evidence and the frequencies are those of the poses that were searched.
/// Several sessions share the effects; what each has of its own is in the model from the start, so
/// that no effect takes it over. Standard deviations of the coefficients are those of calibrate();
/// the cluster bootstrap by pose gives their intervals the form.
TraceResult trace(const Robot& robot, const Campaign& campaign, const Catalogue& catalogue,
                  const TraceOptions& options = {});

}  // namespace armtrue
