#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/driver.h"
#include "armtrue/effects/shape.h"

namespace armtrue {

/// Places of a step that are scanned; the best is then refined.
inline constexpr int kStepGrid = 32;
/// What a width of a degree becomes on a joint that slides: its arc on a pinion of 140 mm [m].
inline constexpr double kTravelForDegree = 2.5e-3;

/// Values of a driver, distinct and ascending.
struct Span {
  std::vector<double> values;
  double length() const { return values.empty() ? 0 : values.back() - values.front(); }
};

/// Of the time [s].
Span time_span(const Campaign& campaign);
/// Of the time [s] or of a joint angle [rad; m of a joint that slides].
Span span_of(const Driver& driver, const Campaign& campaign);

/// Whether there are enough times that an effect could follow them.
inline bool has_time(const Span& span) { return span.values.size() > 2; }

/// Whether the campaign holds what drives the effect, and it changes. `span` is that of the time.
bool is_driven(const Driver& driver, const Campaign& campaign, const Span& span);

/// Places between readings, evenly over their number, at most `count`; the ends leave too few
/// readings to show a step.
std::vector<double> step_places(const Span& span, int count);

/// One shape without inner values (t*, tau), or each of its grid; `degree` as Candidate has it.
std::vector<Shape> with_inner_values(const Shape& shape, const Span& span, double degree);

}  // namespace armtrue
