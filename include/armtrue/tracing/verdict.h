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
};

/// As in the files: `closed`, `nothing-to-explain`, `not-separable`, `unexplained`.
std::string to_string(Verdict verdict);

/// What a verdict is drawn from.
struct Grounds {
  const std::vector<TracedEffect>& effects;
  std::optional<double> lack_of_fit;   ///< p, of the final model on the training poses
  bool noise_from_replicates = false;  ///< else the noise is that of the instrument alone
  double remaining_p = 1;              ///< family-wise p of the best candidate left
  double after = 0, floor = 0;         ///< mean held-out error, and that of a perfect model [m]
};

/// `unexplained` if the lack of fit is significant (p < 0.01) and either the noise is that of
/// replicates or a candidate still shows (p < 0.01): a floor of the instrument alone makes every
/// arm look unexplained. `unexplained`, too, if no effect was found but the held-out error is more
/// than twice the floor. `not_separable` if an effect has a rival of the catalogue; a curve without
/// a known cause is no other cause.
Verdict conclude(const Grounds& grounds);

}  // namespace armtrue
