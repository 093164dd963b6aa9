#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/driver.h"
#include "armtrue/effects/shape.h"
#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Places of a step that are scanned; the best is then refined.
inline constexpr int kStepGrid = 32;
/// Width on a prismatic joint that corresponds to one degree: its arc on a pinion of 140 mm [m].
inline constexpr double kTravelForDegree = 2.5e-3;

/// Values of a driver, distinct and ascending.
struct Span {
  std::vector<double> values;
  double length() const { return values.empty() ? 0 : values.back() - values.front(); }
};

/// Values of the time [s].
Span time_span(const Campaign& campaign);
/// Values of the time [s], of a joint angle [rad; m for a prismatic joint] or of sessions, which are
/// their numbers.
Span span_of(const Driver& driver, const Campaign& campaign);

/// The least and the largest value of a joint in the readings [rad or m].
std::pair<double, double> travel_covered(const Campaign& campaign, int joint);
/// The range of a curve over a joint: what the readings cover and a quarter of that at each end, as
/// far as the joint travels. Cosines are level at the ends of their range.
std::pair<double, double> range_of_curve(const Campaign& campaign, int joint,
                                         const KinematicChain& chain);

/// The driver of what happened between sessions: nothing if there are none, or if times show it,
/// because each session begins after another has ended.
std::optional<Driver> session_driver(const Campaign& campaign);

/// Whether there are enough different times for an effect of time.
inline bool has_time(const Span& span) { return span.values.size() > 2; }

/// Whether the campaign has the driver and its value changes: it differs from its commonest value at
/// three poses or more. `span`: that of the time.
bool is_driven(const Driver& driver, const Campaign& campaign, const Span& span);

/// The time from which an effect of time counts: zero, or the first reading if zero is farther from
/// it than the readings last. A slope over a time far from zero is nearly a constant.
double begin_of_time(const Span& span);

/// At most `count` places between readings, evenly over their number. Places near the ends are left
/// out: too few readings there would show a step.
std::vector<double> step_places(const Span& span, int count);

/// Whether a reading shows at least a quarter of the height that a bump has over the travel
/// covered. In a gap of the readings, they show its flanks alone, and its height is not determined.
bool shows_bump(const Shape& bump, const Span& readings);

/// One shape without inner values (t*, tau), or each of its grid; `degree` as Candidate has it.
std::vector<Shape> with_inner_values(const Shape& shape, const Span& span, double degree);

}  // namespace armtrue
