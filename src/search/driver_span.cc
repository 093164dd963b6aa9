#include "search/driver_span.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

#include "armtrue/campaign/sessions.h"

namespace armtrue {

Span time_span(const Campaign& campaign) {
  const std::set<double> distinct(campaign.time_s.begin(), campaign.time_s.end());
  return {{distinct.begin(), distinct.end()}};
}

Span span_of(const Driver& driver, const Campaign& campaign) {
  if (driver.kind == DriverKind::session) {
    Span numbers;
    for (size_t k = 0; k < driver.sessions.size(); ++k)
      numbers.values.push_back(static_cast<double>(k));
    return numbers;
  }
  if (driver.kind != DriverKind::joint_angle) return time_span(campaign);
  std::set<double> distinct;
  for (const JointVector& q : campaign.q) distinct.insert(q[driver.joint]);
  return {{distinct.begin(), distinct.end()}};
}

std::pair<double, double> travel_covered(const Campaign& campaign, int joint) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& q : campaign.q) {
    low = std::min(low, q[joint]);
    high = std::max(high, q[joint]);
  }
  return {low, high};
}

std::pair<double, double> range_of_curve(const Campaign& campaign, int joint,
                                         const KinematicChain& chain) {
  constexpr double kMargin = 0.25;
  const auto [low, high] = travel_covered(campaign, joint);
  const auto [least, most] = travel(joint_link(chain, joint));
  const double margin = kMargin * (high - low);
  return {std::min(low, std::max(low - margin, least)),
          std::max(high, std::min(high + margin, most))};
}

std::optional<Driver> session_driver(const Campaign& campaign) {
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  if (sessions.size() < 2) return std::nullopt;
  Driver driver{DriverKind::session, -1, -1, ""};
  std::vector<std::pair<double, double>> times;  // first and last of each session
  for (const std::vector<int>& rows : sessions) {
    driver.sessions.push_back(session_name(campaign, rows.front()));
    if (campaign.time_s.empty()) continue;
    const auto [first, last] = std::ranges::minmax(
        rows | std::views::transform([&](int row) { return campaign.time_s[row]; }));
    times.emplace_back(first, last);
  }
  if (times.empty()) return driver;
  std::ranges::sort(times);
  // Times that start again in each session do not order the sessions.
  for (size_t k = 1; k < times.size(); ++k)
    if (times[k].first <= times[k - 1].second) return driver;
  return std::nullopt;
}

double begin_of_time(const Span& span) {
  const double first = span.values.empty() ? 0 : span.values.front();
  return std::abs(first) > span.length() ? first : 0;
}

bool shows_bump(const Shape& bump, const Span& readings) {
  constexpr double kLeastShown = 0.25;
  const double middle = 0.5 * (bump.low[0] + bump.high[0]);
  const auto value_at = [&](double x) {
    double value = 0;
    evaluate(bump, x, &value);
    return value;
  };
  double shown = 0;
  for (const double x : readings.values) shown = std::max(shown, value_at(x));
  // Outside the travel the highest place is one of its ends, which are readings.
  const bool is_within = middle >= readings.values.front() && middle <= readings.values.back();
  return !is_within || shown >= kLeastShown * value_at(middle);
}

std::vector<double> step_places(const Span& span, int count) {
  std::vector<double> steps;
  const size_t n = span.values.size();
  for (int k = 1; k <= count; ++k) {
    const size_t i = n * static_cast<size_t>(k) / static_cast<size_t>(count + 1);
    if (i < 1 || i >= n) continue;
    const double at = 0.5 * (span.values[i - 1] + span.values[i]);
    if (steps.empty() || at > steps.back()) steps.push_back(at);
  }
  return steps;
}

namespace {

std::vector<double> scales_of(const Shape& shape, const Span& span, double degree) {
  if (shape.kind == ShapeKind::pre_sliding)
    return {0.5 * degree, 1 * degree, 2 * degree, 4 * degree, 8 * degree, 16 * degree, 32 * degree};
  std::vector<double> constants;
  for (double share : {0.05, 0.1, 0.2, 0.4, 0.8}) constants.push_back(share * span.length());
  return constants;
}

}  // namespace

std::vector<Shape> with_inner_values(const Shape& shape, const Span& span, double degree) {
  std::vector<Shape> shapes;
  if (has_at(shape.kind))
    for (double at : step_places(span, kStepGrid)) {
      shapes.push_back(shape);
      shapes.back().at = at;
    }
  else if (has_tau(shape.kind))
    for (double tau : scales_of(shape, span, degree)) {
      shapes.push_back(shape);
      shapes.back().tau = tau;
    }
  else
    shapes.push_back(shape);
  return shapes;
}

namespace {

// Poses at which a driver must have another value than its commonest one. A value at a single pose
// would explain that pose's own error, so a blunder would look like an effect.
constexpr size_t kPosesOfLevel = 3;

// Whether a value that each row has, or has not, differs between the rows of several poses. `value`
// returns an optional.
template <typename Value>
bool has_contrast(const Campaign& campaign, const Value& value) {
  using Level = typename std::invoke_result_t<Value, int>::value_type;
  std::map<Level, std::set<int>> poses_of_level;
  for (int row = 0; row < campaign.rows(); ++row)
    if (const auto level = value(row)) poses_of_level[*level].insert(campaign.pose[row]);
  if (poses_of_level.size() < 2) return false;
  const auto commonest = std::ranges::max_element(
      poses_of_level, {}, [](const auto& level) { return level.second.size(); });
  std::set<int> others;
  for (const auto& [level, poses] : poses_of_level)
    if (level != commonest->first) others.insert(poses.begin(), poses.end());
  return others.size() >= kPosesOfLevel;
}

// `joint`: of the driver, -1 if it has none.
bool is_driven(DriverKind kind, int joint, const std::string& where, const Campaign& campaign,
               const Span& span) {
  const auto by = [&](const auto& column, const auto& value_in) {
    return !column.empty() &&
           has_contrast(campaign, [&](int row) { return std::optional(value_in(column[row])); });
  };
  switch (kind) {
    case DriverKind::time:
      return has_time(span);
    case DriverKind::session:
      return by(campaign.session, [](int session) { return session; });
    case DriverKind::payload:
      return by(campaign.payload_kg, [](double mass) { return mass; });
    case DriverKind::force:
      return by(campaign.force_n,
                [](const Eigen::Vector3d& force) { return std::array{force[0], force[1], force[2]}; });
    case DriverKind::temperature: {
      const auto sensor = std::ranges::find(campaign.temperature_names, where);
      if (sensor == campaign.temperature_names.end()) return false;
      const size_t k = sensor - campaign.temperature_names.begin();
      return by(campaign.temperature_c, [k](const auto& row) { return row[k]; });
    }
    case DriverKind::motor_torque:
      return by(campaign.motor_torque_nm, [joint](const auto& row) { return row[joint]; });
    case DriverKind::stroke:
      return by(campaign.stroke, [joint](const JointVector& stroke) { return stroke[joint]; });
    case DriverKind::arrival:
      // 0 is no direction: the joint has not moved yet.
      return !campaign.arrival.empty() && has_contrast(campaign, [&](int row) {
        const int sign = campaign.arrival[row][joint];
        return sign == 0 ? std::nullopt : std::optional(sign);
      });
    default:
      return missing_column(campaign, kind, where).empty();
  }
}

}  // namespace

bool is_driven(const Driver& driver, const Campaign& campaign, const Span& span) {
  return is_driven(driver.kind, driver.joint, driver.where, campaign, span) &&
         (!driver.factor ||
          is_driven(*driver.factor, driver.second_joint, driver.where, campaign, span));
}

}  // namespace armtrue
