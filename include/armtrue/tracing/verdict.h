#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

struct TracedEffect;

/// The conclusion of close_loop().
enum class Verdict {
  closed,              ///< effects were found, and nothing significant is left
  nothing_to_explain,  ///< no effect was found and the residual is noise
  not_separable,  ///< effects were found, but these readings cannot tell which of several causes it
                  ///< is
  unexplained,    ///< a significant part of the residual is left
  too_few_poses,  ///< the errors of held-out poses exceed noise, and these poses are too few to
                  ///< show why
  unknown_noise,  ///< neither repeats nor the robot file say how large the noise is, so nothing
                  ///< shows whether more than noise is left
};

/// As in the files: `closed`, `nothing-to-explain`, `not-separable`, `unexplained`,
/// `too-few-poses`, `unknown-noise`.
std::string to_string(Verdict verdict);

/// The figures that decide the verdict.
struct Grounds {
  const std::vector<TracedEffect>& effects;
  std::optional<double> lack_of_fit;  ///< p, of the final model on the training poses
  bool knows_noise = true;            ///< by replicates or as stated; false: `floor` is 0
  double after = 0, floor = 0;        ///< mean held-out error, and that of a perfect model [m]
  /// A mean held-out error above this exceeds noise [m].
  double floor_high = 0;
  /// 99 % quantile of the mean held-out error of a complete model fitted to these poses [m].
  double complete_high = 0;
  /// p of the number of held-out poses beyond their 95 % bounds; see p_of_errors().
  double outside_p = 1;
  bool left_out_together = false;  ///< see left_out_together()
  bool is_explained = false;       ///< the residual has a cause, see explanation_of_rest()
  bool wanders = false;            ///< see LoopResult::wandering
  bool pattern_remains = false;    ///< see TraceResult::pattern_remains
  bool all_from_few = false;       ///< see LoopResult::all_from_few
  bool unconfirmed_curve = false;  ///< see LoopResult::unconfirmed_curve
};

/// Whether these readings do not tell the cause of an effect, or not that the arm moves by it.
bool is_undecided(const TracedEffect& traced);

/// Whether the arm follows the time along a curve that no listed cause explains: it is known for
/// the time of the campaign alone, and nobody knows what it does on another day.
bool is_curve_of_time(const TracedEffect& traced);

/// The mean backlash of the joints [rad], if three of them at least have backlash and all have the
/// same. Each gear has its own backlash; joint angles read before standstill look like a common
/// one. Above zero the joints went on in the direction in which they came, as no backlash does:
/// they are half of the joints or more, and the same within three standard deviations or a quarter.
/// Below zero, where gears are, they are more than half, and each is known to a quarter and the
/// same within a quarter.
std::optional<double> common_backlash(const KinematicChain& chain,
                                      const std::vector<TracedEffect>& effects);

/// `too_few_poses` if `all_from_few`, unless a cause of the rest is known. Otherwise
/// `unexplained` if the lack of fit is significant (p < 0.01), if too many held-out poses lie
/// beyond their bounds (p < 0.01), if the held-out error exceeds both twice the floor and
/// `complete_high`, if readings are left out together, if the diagnosis explains what is left, or
/// if a pattern remains: then the residual is no noise, however large replicates say that noise is;
/// and if an effect is_curve_of_time().
/// Otherwise `not_separable` if an effect has a rival with is_other_cause() or may be the
/// instrument's or the tool's (programs are not corrected by it), or shares what was found.
/// Otherwise `unknown_noise` without a known noise. Otherwise `too_few_poses` if the held-out error
/// exceeds `floor_high`: then something may be left.
Verdict conclude(const Grounds& grounds);

}  // namespace armtrue
