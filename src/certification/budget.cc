#include "armtrue/certification/budget.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "armtrue/statistics/distributions.h"

namespace armtrue {

Budget budget_of(const StatedUncertainty& stated, const Scatter& scatter, int visits, double range,
                 const std::optional<double>& model, double too_high, double of_frame) {
  const double root = std::sqrt(visits);
  const double noise = stated.noise.value_or(0);
  const double repeats =
      std::sqrt(std::max(0.0, scatter.deviation * scatter.deviation - noise * noise)) / root;
  Budget budget;
  if (stated.noise)
    budget.rows.push_back({"instrument, noise", "normal", noise / root});
  else
    budget.rows.push_back({"instrument, maximum permissible error", "rectangular",
                           (stated.mpe_constant + stated.mpe_per_metre * range) / std::sqrt(3)});
  budget.rows.push_back({"mounting of the reflector", "normal", stated.mounting});
  budget.rows.push_back(
      {"temperature", "rectangular",
       stated.temperature_half_width * stated.expansion * stated.length / std::sqrt(3)});
  if (model) budget.rows.push_back({"model of the robot", "normal", *model});
  budget.rows.push_back({"repeatability", "normal", repeats});
  if (too_high > 0)
    budget.rows.push_back({"largest of many planes", "rectangular", too_high / std::sqrt(3)});
  if (of_frame > 0) budget.rows.push_back({"frame, fitted to the path", "normal", of_frame});
  double squares = 0;
  for (const BudgetRow& row : budget.rows) squares += row.standard * row.standard;
  budget.combined = std::sqrt(squares);
  // The variance of repeats^2 = (s^2 - e^2) / n is that of s^2 / n, however much of it e takes.
  const double shown = scatter.deviation / root;
  budget.freedom = repeats > 0 ? scatter.freedom * squares * squares / std::pow(shown, 4)
                               : std::numeric_limits<double>::infinity();
  constexpr double kFreedomOfNormal = 1e6;  // the law of t is normal there
  // 95.45 % between -k and k: P(X <= k) = 0.97725.
  budget.k =
      budget.freedom < kFreedomOfNormal ? student_t_quantile(normal_below(2), budget.freedom) : 2.0;
  budget.expanded = budget.k * budget.combined;
  return budget;
}

Decision decide(double ap, double expanded, double tolerance) {
  if (ap + expanded <= tolerance) return Decision::pass;
  return ap - expanded > tolerance ? Decision::fail : Decision::undecided;
}

std::string decision_name(Decision decision) {
  if (decision == Decision::undecided) return "undecided";
  return decision == Decision::pass ? "pass" : "fail";
}

}  // namespace armtrue
