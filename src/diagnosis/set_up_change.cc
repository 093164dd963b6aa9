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

constexpr double kFewestInPart = 0.1;  // of the rows, on either side
constexpr double kShareThatMatters = 0.25;

struct SetUpChange {
  double score = 0;       // fall of BIC
  int first_row = -1;     // of the later part, in the order
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
  for (size_t k = change.first_row; k < order.size(); ++k)
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

// Pose numbers by row; empty if an id is no number.
std::vector<double> pose_numbers(const Campaign& campaign) {
  std::vector<double> numbers;
  for (int pose : campaign.pose) {
    const std::string& id = campaign.pose_ids[pose];
    const auto [end, error] =
        std::from_chars(id.data(), id.data() + id.size(), numbers.emplace_back());
    if (error != std::errc() || end != id.data() + id.size()) return {};
  }
  return numbers;
}

struct Order {
  std::string of;  // line, time or pose
  std::vector<int> rows;
};

std::vector<Order> orders_of(const Campaign& campaign) {
  std::vector<Order> orders;
  if (!campaign.time_s.empty()) orders.push_back({"time", sorted_by(campaign.time_s)});
  orders.push_back({"line", sorted_by({campaign.line.begin(), campaign.line.end()})});
  if (const auto numbers = pose_numbers(campaign); !numbers.empty())
    orders.push_back({"pose", sorted_by(numbers)});
  return orders;
}

std::string place_of(size_t row, const Order& order, const Campaign& campaign) {
  if (order.of == "time") return fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  if (order.of == "pose") return "pose " + campaign.pose_ids[campaign.pose[row]];
  return fmt::format("line {}", campaign.line[row]);
}

ChangedPart part_of(const SetUpChange& change, const Order& order, const Campaign& campaign) {
  const size_t row = order.rows[change.first_row];
  std::string by_time;
  if (order.of == "time")
    by_time = fmt::format("--new-session-at-s {:.10g} or ", campaign.time_s[row]);
  return {
      fmt::format("from {} on, in the order of the {}s,", place_of(row, order, campaign), order.of),
      by_time + "a column 'session'"};
}

}  // namespace

std::optional<Suspicion> find_set_up_change(const PlainFit& fit) {
  const Campaign& sample = fit.readings;
  const Causes causes = possible_causes(fit, true);
  const std::vector<Order> orders = orders_of(sample);
  const auto choices = static_cast<double>(orders.size() * causes.all.size());
  const double poses = fit.poses();
  const FitEquations equations = fit_equations(fit, causes.parameters);
  const Order* found = nullptr;
  const Cause* found_cause = nullptr;
  SetUpChange best{.score = kClearFall};
  for (const Cause& cause : causes.all)
    for (const Order& order : orders) {
      const SetUpChange change = best_place(equations, cause, order.rows, poses, choices);
      if (change.score <= best.score ||
          !is_of_most(explained_by(change, equations, cause, order.rows), equations))
        continue;
      best = change;
      found = &order;
      found_cause = &cause;
    }
  if (!found) return std::nullopt;
  return Suspicion{best.score,
                   describe_change(*found_cause, best.moved, fit, part_of(best, *found, sample))};
}

}  // namespace armtrue
