#include "armtrue/tracing/verdict.h"

#include <algorithm>
#include <cmath>

#include "armtrue/effects/flange_or_tool.h"
#include "armtrue/kinematics/parameters.h"
#include "armtrue/search/trace.h"

namespace armtrue {
namespace {

constexpr double kSignificance = 0.01;
constexpr double kMaxTimesFloor = 2.0;  // held-out errors of few poses scatter up to this

}  // namespace

bool is_undecided(const TracedEffect& traced) {
  return traced.effect.may_be_instrument || is_of_flange_or_tool(traced.effect) ||
         !traced.shared_with.empty() ||
         std::ranges::any_of(traced.indistinguishable, [&](const Rival& rival) {
           return is_other_cause(traced.effect, rival);
         });
}

bool is_curve_of_time(const TracedEffect& traced) {
  const Driver& driver = traced.effect.driver;
  return driver.kind == DriverKind::time && !driver.factor && traced.in_words.empty() &&
         traced.effect.shape.kind == ShapeKind::series && moved_by(traced.effect) == Moved::arm;
}

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

std::optional<double> common_backlash(const KinematicChain& chain,
                                      const std::vector<TracedEffect>& effects) {
  constexpr size_t kFewestJoints = 3;
  constexpr double kDeviations = 3, kQuarter = 0.25;
  struct Backlash {
    double value, std;
  };
  std::vector<Backlash> found;
  double sum = 0, weight = 0;
  for (const TracedEffect& traced : effects) {
    const Effect& effect = traced.effect;
    if (effect.driver.kind != DriverKind::arrival || effect.driver.factor ||
        effect.shape.kind != ShapeKind::sign ||
        first_parameter(chain, effect.parameter) != zero_offset(chain, effect.driver.joint))
      continue;
    const Coefficient& c = effect.coefficients.front();
    if (c.std <= 0 || is_prismatic(joint_link(chain, effect.driver.joint))) continue;
    found.push_back({joint_link(chain, effect.driver.joint).sign * c.value, c.std});
    sum += found.back().value / (c.std * c.std);
    weight += 1 / (c.std * c.std);
  }
  if (found.size() < kFewestJoints) return std::nullopt;
  const double mean = sum / weight;
  const bool go_on = mean > 0;
  const auto twice = 2 * static_cast<int>(found.size());
  if (twice < joint_count(chain) || (!go_on && twice == joint_count(chain))) return std::nullopt;
  const double near = kQuarter * std::abs(mean);
  const bool are_alike = std::ranges::all_of(found, [&](const Backlash& backlash) {
    const double apart = std::abs(backlash.value - mean), clear = kDeviations * backlash.std;
    return go_on ? apart < std::max(near, clear) : apart < near && clear < near;
  });
  return are_alike ? std::optional(mean) : std::nullopt;
}

Verdict conclude(const Grounds& grounds) {
  if (grounds.left_out_together || grounds.is_explained || grounds.wanders ||
      grounds.pattern_remains || std::ranges::any_of(grounds.effects, is_curve_of_time))
    return Verdict::unexplained;
  if (grounds.all_from_few) return Verdict::too_few_poses;
  if (grounds.lack_of_fit && *grounds.lack_of_fit < kSignificance) return Verdict::unexplained;
  if (grounds.outside_p < kSignificance) return Verdict::unexplained;
  const bool beyond_floor = grounds.floor > 0 && grounds.after > grounds.floor_high;
  // Held-out poses may show an error that too few training poses cannot show.
  const double most = std::max(grounds.complete_high, kMaxTimesFloor * grounds.floor);
  if (beyond_floor && grounds.after > most) return Verdict::unexplained;
  if (std::ranges::any_of(grounds.effects, is_undecided)) return Verdict::not_separable;
  if (!grounds.knows_noise) return Verdict::unknown_noise;
  if (beyond_floor) return Verdict::too_few_poses;
  if (grounds.unconfirmed_curve) return Verdict::unexplained;
  return grounds.effects.empty() ? Verdict::nothing_to_explain : Verdict::closed;
}

}  // namespace armtrue
