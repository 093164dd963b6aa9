#include "armtrue/tracing/verdict.h"

#include <algorithm>

#include "armtrue/search/trace.h"

namespace armtrue {
namespace {

constexpr double kSignificance = 0.01;
constexpr double kMaxTimesFloor = 2.0;  // held-out errors of few poses scatter up to this

bool has_other_cause(const TracedEffect& traced) {
  return std::any_of(traced.indistinguishable.begin(), traced.indistinguishable.end(),
                     [&](const Rival& rival) { return is_other_cause(traced.effect, rival); });
}

}  // namespace

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::closed:
      return "closed";
    case Verdict::nothing_to_explain:
      return "nothing-to-explain";
    case Verdict::not_separable:
      return "not-separable";
    case Verdict::too_few_poses:
      return "too-few-poses";
    case Verdict::unknown_noise:
      return "unknown-noise";
    case Verdict::unexplained:
      break;
  }
  return "unexplained";
}

Verdict conclude(const Grounds& grounds) {
  if (grounds.lack_of_fit && *grounds.lack_of_fit < kSignificance) return Verdict::unexplained;
  if (grounds.outside_p < kSignificance) return Verdict::unexplained;
  if (grounds.left_out_together || grounds.is_explained) return Verdict::unexplained;
  const bool beyond_floor = grounds.floor > 0 && grounds.after > grounds.floor_high;
  // Held-out poses may show an error that too few training poses cannot show.
  const double most = std::max(grounds.complete_high, kMaxTimesFloor * grounds.floor);
  if (beyond_floor && grounds.after > most) return Verdict::unexplained;
  if (std::ranges::any_of(grounds.effects, has_other_cause)) return Verdict::not_separable;
  if (!grounds.knows_noise) return Verdict::unknown_noise;
  if (beyond_floor) return Verdict::too_few_poses;
  return grounds.effects.empty() ? Verdict::nothing_to_explain : Verdict::closed;
}

}  // namespace armtrue
