#include "diagnosis/station_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "armtrue/kinematics/parameters.h"
#include "diagnosis/changed_cause.h"

namespace armtrue {
namespace {

// The sessions in which a cause is tried, and how they are called.
struct Part {
  std::vector<int> sessions;
  std::string words;
};

// Rows of the equations that a part of the readings has.
std::vector<char> rows_of(const Part& part, const Campaign& readings) {
  std::vector<char> in_part(readings.session.size());
  for (size_t row = 0; row < in_part.size(); ++row)
    in_part[row] = std::ranges::find(part.sessions, readings.session[row]) != part.sessions.end();
  return in_part;
}

Eigen::MatrixXd columns_of(const Cause& cause, const std::vector<char>& in_part,
                           const FitEquations& equations) {
  Eigen::MatrixXd columns = equations.columns.middleCols(cause.first_column, cause.count);
  for (int row = 0; row < std::ssize(in_part); ++row)
    if (!in_part[row]) columns.middleRows(row * equations.row_size, equations.row_size).setZero();
  return columns;
}

struct Explained {
  double score = 0;  // fall of BIC
  Eigen::VectorXd value;
};

Explained explain(const Eigen::MatrixXd& columns, const FitEquations& equations, double poses,
                  double choices, double least_share) {
  const JointFit joint = fit_beside(columns, equations);
  Explained found;
  const double score = fall_of_bic(joint, equations, poses, choices);
  if (joint.share < least_share || score < kClearFall) return found;
  if (!is_of_most(columns * joint.value, equations)) return found;
  return {score, joint.value};
}

double poses_of(const Campaign& readings) {
  std::set<std::pair<int, int>> poses;
  for (size_t row = 0; row < readings.pose.size(); ++row)
    poses.emplace(readings.pose[row], readings.session.empty() ? 0 : readings.session[row]);
  return static_cast<double>(poses.size());
}

// Each session alone, and all from one on, in the order of their first rows.
std::vector<Part> parts_of(const Campaign& readings) {
  std::vector<int> order;
  for (const int session : readings.session)
    if (std::ranges::find(order, session) == order.end()) order.push_back(session);
  std::vector<Part> parts;
  if (order.size() < 2) return parts;
  const auto name = [&](size_t k) {
    return fmt::format("session '{}'", readings.session_names[order[k]]);
  };
  // Of two sessions the other differs by the same.
  for (size_t k = order.size() == 2 ? 1 : 0; k < order.size(); ++k)
    parts.push_back({{order[k]}, fmt::format("in {}", name(k))});
  for (size_t k = 1; k + 1 < order.size(); ++k)
    parts.push_back({{order.begin() + k, order.end()}, fmt::format("from {} on", name(k))});
  return parts;
}

// The share of the squared residual that positions have; orientations do not show the range.
double share_of_positions(const FitEquations& equations, const Campaign& readings) {
  double positions = 0;
  for (Eigen::Index row = 0; row < readings.rows(); ++row)
    positions +=
        equations.residual.segment(row * equations.row_size, readings.reading_size().position)
            .squaredNorm();
  return positions / std::max(1e-300, equations.residual.squaredNorm());
}

}  // namespace

std::optional<Suspicion> find_constant_of_range(const PlainFit& fit) {
  constexpr double kShareThatMatters = 0.5;
  const Campaign& readings = fit.readings;
  if (readings.reads_one_number() || readings.has_touches()) return std::nullopt;
  const int range = layout_of(fit.result.robot.chain).instrument_range;
  const FitEquations equations = fit_equations(fit, {range});
  const Explained found = explain(equations.columns, equations, poses_of(readings), 1,
                                  kShareThatMatters * share_of_positions(equations, readings));
  if (found.score <= 0) return std::nullopt;
  return Suspicion{found.score, describe_change({Cause::Kind::range, 0, 1, range}, found.value, fit,
                                                {"all", ""})};
}

std::optional<Suspicion> find_change_of_session(const PlainFit& fit) {
  constexpr double kShareThatMatters = 0.25;
  const Campaign& readings = fit.readings;
  if (readings.session.empty() || readings.has_touches()) return std::nullopt;
  const std::vector<Part> parts = parts_of(readings);
  if (parts.empty()) return std::nullopt;
  const Causes causes = possible_causes(fit, false);
  const FitEquations equations = fit_equations(fit, causes.parameters);
  const double poses = poses_of(readings);
  const auto choices = static_cast<double>(causes.all.size() * parts.size());
  std::optional<Suspicion> best;
  for (const Part& part : parts) {
    const std::vector<char> in_part = rows_of(part, readings);
    for (const Cause& cause : causes.all) {
      const Explained found = explain(columns_of(cause, in_part, equations), equations, poses,
                                      choices, kShareThatMatters);
      if (found.score <= (best ? best->score : 0)) continue;
      best = Suspicion{found.score, describe_change(cause, found.value, fit, {part.words, ""})};
    }
  }
  return best;
}

}  // namespace armtrue
