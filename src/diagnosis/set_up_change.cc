#include "diagnosis/set_up_change.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <vector>

#include "diagnosis/changed_cause.h"

namespace armtrue {
namespace {

constexpr double kFewestInPart = 0.1;  // of the readings, on either side
constexpr double kShareThatMatters = 0.25;

struct SetUpChange {
  double score = 0;       // fall of BIC
  int first = -1;         // reading of the later part, in the order
  Eigen::VectorXd moved{};  // the value of the cause
};

// The place in an order of the rows after which another value of a cause explains most.
SetUpChange best_place(const FitEquations& equations, const Cause& cause,
                       const std::vector<int>& order, double poses, double choices) {
  const auto rows = static_cast<int>(order.size());
  const int size = equations.row_size;
  const Eigen::Index unknowns = cause.count;
  Eigen::MatrixXd on_basis = Eigen::MatrixXd::Zero(equations.basis.cols(), unknowns);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(unknowns);
  SetUpChange best;
  for (int k = rows - 1; k > 0; --k) {
    const int first = order[k] * size;
    const auto columns = equations.columns.block(first, cause.first_column, size, unknowns);
    on_basis.noalias() += equations.basis.middleRows(first, size).transpose() * columns;
    gram.noalias() += columns.transpose() * columns;
    slope.noalias() += columns.transpose() * equations.residual.segment(first, size);
    if (std::min(k, rows - k) < kFewestInPart * rows) continue;
    const JointFit joint = fit_beside(gram, on_basis, slope, equations);
    if (joint.share < kShareThatMatters) continue;
    const double score = fall_of_bic(joint, equations, poses, choices * rows);
    if (score > best.score) best = {score, k, joint.value};
  }
  return best;
}

Eigen::VectorXd explained_by(const SetUpChange& change, const FitEquations& equations,
                             const Cause& cause, const std::vector<int>& order) {
  const int size = equations.row_size;
  Eigen::VectorXd later = Eigen::VectorXd::Zero(equations.residual.size());
  for (size_t k = change.first; k < order.size(); ++k)
    later.segment(order[k] * size, size) =
        equations.columns.block(order[k] * size, cause.first_column, size, cause.count) *
        change.moved;
  return later;
}

std::vector<int> sorted_by(const std::vector<double>& keys) {
  std::vector<int> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int row) { return keys[row]; });
  return order;
}

// Pose numbers of rows; empty if an id is no number.
std::vector<double> pose_numbers(const Campaign& campaign, const std::vector<int>& rows) {
  std::vector<double> numbers;
  for (int row : rows) {
    const std::string& id = campaign.pose_ids[campaign.pose[row]];
    const auto [end, error] =
        std::from_chars(id.data(), id.data() + id.size(), numbers.emplace_back());
    if (error != std::errc() || end != id.data() + id.size()) return {};
  }
  return numbers;
}

struct Order {
  std::string of;             // line, time or pose
  std::vector<int> readings;  // of the equations
};

std::vector<Order> orders_of(const Campaign& campaign, const FitEquations& equations) {
  std::vector<int> first;
  for (const std::vector<int>& rows : equations.rows) first.push_back(rows.front());
  const auto at = [&](const auto& column) {
    std::vector<double> values;
    for (int row : first) values.push_back(column[row]);
    return values;
  };
  std::vector<Order> orders;
  if (!campaign.time_s.empty()) orders.push_back({"time", sorted_by(at(campaign.time_s))});
  orders.push_back({"line", sorted_by(at(campaign.line))});
  if (const auto numbers = pose_numbers(campaign, first); !numbers.empty())
    orders.push_back({"pose", sorted_by(numbers)});
  return orders;
}

std::string place_of(int row, const Order& order, const Campaign& campaign) {
  if (order.of == "time") return fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  if (order.of == "pose") return "pose " + campaign.pose_ids[campaign.pose[row]];
  return fmt::format("line {}", campaign.line[row]);
}

// `last`: row of the last reading before the change; `first`: of the one behind it.
ChangedPart part_of(int last, int first, const Order& order, const Campaign& campaign) {
  const auto pose = [&](int row) { return campaign.pose_ids[campaign.pose[row]]; };
  if (campaign.has_pixels_only())
    return {fmt::format("between the images of pose {} and pose {}, in the order of the {}s,",
                        pose(last), pose(first), order.of),
            ""};
  std::string by_time;
  if (order.of == "time")
    by_time = fmt::format("--new-session-at-s {:.10g} or ", campaign.time_s[first]);
  return {fmt::format("from {} on, in the order of the {}s,", place_of(first, order, campaign),
                      order.of),
          by_time + "a column 'session'"};
}

}  // namespace

std::optional<Suspicion> find_set_up_change(const PlainFit& fit) {
  const Campaign& sample = fit.readings;
  const Causes causes = possible_causes(fit, true);
  const double poses = fit.poses();
  const FitEquations equations = reading_equations(fit, causes.parameters);
  const std::vector<Order> orders = orders_of(sample, equations);
  const auto choices = static_cast<double>(orders.size() * causes.all.size());
  const Order* found = nullptr;
  const Cause* found_cause = nullptr;
  SetUpChange best{.score = kClearFall};
  for (const Cause& cause : causes.all)
    for (const Order& order : orders) {
      const SetUpChange change = best_place(equations, cause, order.readings, poses, choices);
      if (change.score <= best.score ||
          !is_of_most(explained_by(change, equations, cause, order.readings), equations))
        continue;
      best = change;
      found = &order;
      found_cause = &cause;
    }
  if (!found) return std::nullopt;
  const auto row_of = [&](int k) { return equations.rows[found->readings[k]].front(); };
  return Suspicion{best.score, describe_change(*found_cause, best.moved, fit,
                                               part_of(row_of(best.first - 1), row_of(best.first),
                                                       *found, sample))};
}

}  // namespace armtrue
