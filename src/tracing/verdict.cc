#include "armtrue/tracing/verdict.h"

#include <algorithm>

#include "armtrue/tracing/tracing.h"

namespace armtrue {
namespace {

constexpr double kSignificance = 0.01;
constexpr double kMaxTimesFloor = 2.0;  // held-out errors of few poses scatter up to this

bool has_other_cause(const TracedEffect& traced) {
  return std::any_of(traced.indistinguishable.begin(), traced.indistinguishable.end(),
                     [](const Rival& rival) { return rival.from_catalogue; });
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
    case Verdict::unexplained:
      break;
  }
  return "unexplained";
}

Verdict conclude(const Grounds& grounds) {
  const bool lacks_something = grounds.lack_of_fit && *grounds.lack_of_fit < kSignificance;
  if (lacks_something && (grounds.noise_from_replicates || grounds.remaining_p < kSignificance))
    return Verdict::unexplained;
  // Held-out poses may show what too few training poses cannot.
  if (grounds.effects.empty())
    return grounds.floor > 0 && grounds.after > kMaxTimesFloor * grounds.floor
               ? Verdict::unexplained
               : Verdict::nothing_to_explain;
  return std::any_of(grounds.effects.begin(), grounds.effects.end(), has_other_cause)
             ? Verdict::not_separable
             : Verdict::closed;
}

}  // namespace armtrue
