#include "tracing/rows_at_steps.h"

#include <algorithm>
#include <limits>
#include <set>
#include <span>

namespace armtrue {

std::vector<int> rows_at_steps(const TraceResult& trace, const Campaign& training,
                               const Campaign& held_out) {
  std::set<int> rows;
  const std::vector<Effect>& effects = trace.fit.robot.effects;
  for (const Effect& effect :
       std::span(effects).subspan(trace.stages.front().robot.effects.size())) {
    if (effect.driver.kind != DriverKind::time || effect.shape.kind != ShapeKind::step) continue;
    double before = -std::numeric_limits<double>::infinity(), after = -before;
    for (const double time : training.time_s)
      if (time < effect.shape.at)
        before = std::max(before, time);
      else
        after = std::min(after, time);
    for (int row = 0; row < std::ssize(held_out.time_s); ++row)
      if (held_out.time_s[row] > before && held_out.time_s[row] < after) rows.insert(row);
  }
  return {rows.begin(), rows.end()};
}

}  // namespace armtrue
