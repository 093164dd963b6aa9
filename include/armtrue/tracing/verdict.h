#pragma once

#include <optional>
#include <string>
#include <vector>

namespace armtrue {

struct TracedEffect;

/// What close_loop concludes.
enum class Verdict {
  closed,              ///< effects were found, and nothing significant is left
  nothing_to_explain,  ///< no effect was found and the residual is noise
  not_separable,  ///< effects were found, but which of several causes it is this data cannot tell
  unexplained,    ///< a significant part of the residual is left
  too_few_poses,  ///< held-out poses err by more than noise, and these poses do not tell why
};

/// As in the files: `closed`, `nothing-to-explain`, `not-separable`, `unexplained`,
/// `too-few-poses`.
std::string to_string(Verdict verdict);

/// What a verdict is drawn from.
struct Grounds {
  const std::vector<TracedEffect>& effects;
  std::optional<double> lack_of_fit;  ///< p, of the final model on the training poses
  double after = 0, floor = 0;        ///< mean held-out error, and that of a perfect model [m]
  /// Above this the held-out error is not called noise [m].
  double floor_high = 0;
  /// What a complete model, fitted to these poses, scores in 99 % of cases at most [m].
  double complete_high = 0;
  /// p of so many held-out poses beyond their 95 % bounds, if the bounds hold.
  double outside_p = 1;
};

/// `unexplained` if the lack of fit is significant (p < 0.01), if held-out poses lie beyond what
/// was predicted of them (p < 0.01), or if no effect was found and the held-out error is more than
/// twice the floor and than a complete model's would be. `not_separable` if an effect has a rival
/// of the catalogue; a curve without a known cause is no other cause. `too_few_poses` if the
/// held-out error is above `floor_high`: nobody can say then that nothing is left.
Verdict conclude(const Grounds& grounds);

}  // namespace armtrue
