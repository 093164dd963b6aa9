#include "search/driver_span.h"

#include <algorithm>
#include <set>
#include <string>

namespace armtrue {

Span time_span(const Campaign& campaign) {
  const std::set<double> distinct(campaign.time_s.begin(), campaign.time_s.end());
  return {{distinct.begin(), distinct.end()}};
}

Span span_of(const Driver& driver, const Campaign& campaign) {
  if (driver.kind != DriverKind::joint_angle) return time_span(campaign);
  std::set<double> distinct;
  for (const JointVector& q : campaign.q) distinct.insert(q[driver.joint]);
  return {{distinct.begin(), distinct.end()}};
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

template <typename Values>
bool varies(const Values& values) {
  return std::any_of(values.begin(), values.end(),
                     [&](const auto& value) { return value != values.front(); });
}

bool is_driven(DriverKind kind, const std::string& where, const Campaign& campaign,
               const Span& span) {
  switch (kind) {
    case DriverKind::time:
      return has_time(span);
    case DriverKind::payload:
      return varies(campaign.payload_kg);
    case DriverKind::force:
      return varies(campaign.force_n);
    default:
      return missing_column(campaign, kind, where).empty();
  }
}

}  // namespace

bool is_driven(const Driver& driver, const Campaign& campaign, const Span& span) {
  return is_driven(driver.kind, driver.where, campaign, span) &&
         (!driver.factor || is_driven(*driver.factor, driver.where, campaign, span));
}

}  // namespace armtrue
