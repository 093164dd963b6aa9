#include "diagnosis/set_up_change.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kFewestInPart = 0.1;  // of the rows, on either side
constexpr double kShareThatMatters = 0.25;
constexpr double kNearer = 0.8;    // the median residual, by the change
constexpr double kClearFall = 20;  // BIC

struct SetUpChange {
  double score = 0;       // fall of BIC
  int first_row = -1;     // of the later part, in the order
  Eigen::VectorXd moved;  // its base or tool: x y z, of poses also rx ry rz
};

// The place in an order of the rows after which another base, or another tool, explains most.
SetUpChange best_place(const FitEquations& equations, const std::vector<int>& order, double poses,
                       double choices) {
  const auto rows = static_cast<int>(order.size());
  const int size = equations.row_size;
  const double whole = equations.residual.squaredNorm();
  // What the residual is worth: of few poses the fit uses most equations, and another base the
  // rest.
  const double freedom = poses * size - static_cast<double>(equations.basis.cols());
  const Eigen::Index unknowns = equations.columns.cols();
  Eigen::MatrixXd on_basis = Eigen::MatrixXd::Zero(equations.basis.cols(), unknowns);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(unknowns);
  SetUpChange best;
  if (freedom <= static_cast<double>(unknowns)) return best;
  for (int k = rows - 1; k > 0; --k) {
    const int first = order[static_cast<size_t>(k)] * size;
    const auto columns = equations.columns.middleRows(first, size);
    on_basis.noalias() += equations.basis.middleRows(first, size).transpose() * columns;
    gram.noalias() += columns.transpose() * columns;
    slope.noalias() += columns.transpose() * equations.residual.segment(first, size);
    if (std::min(k, rows - k) < kFewestInPart * rows) continue;
    Eigen::MatrixXd beside = gram - on_basis.transpose() * on_basis;
    const Eigen::VectorXd unit = gram.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    beside = unit.asDiagonal() * beside * unit.asDiagonal();
    beside.diagonal().array() += 1e-9;  // what the others show as well takes no part
    const Eigen::VectorXd scaled = unit.asDiagonal() * slope;
    const Eigen::VectorXd moved = Eigen::LDLT<Eigen::MatrixXd>(beside).solve(scaled);
    const double share = std::min(1 - 1e-12, moved.dot(scaled) / std::max(1e-300, whole));
    if (share < kShareThatMatters) continue;
    const double score = -freedom * std::log(1 - share) -
                         static_cast<double>(unknowns) * std::log(freedom) -
                         2 * std::log(choices * rows);
    if (score > best.score) best = {score, k, unit.asDiagonal() * moved};
  }
  return best;
}

double median_norm(const Eigen::VectorXd& residual, int row_size) {
  std::vector<double> norms;
  for (Eigen::Index first = 0; first < residual.size(); first += row_size)
    norms.push_back(residual.segment(first, row_size).norm());
  return median(norms);
}

// Whether the errors of most readings fall, not only those of a few blunders.
bool is_of_most(const SetUpChange& change, const FitEquations& equations,
                const std::vector<int>& order) {
  const int size = equations.row_size;
  Eigen::VectorXd later = Eigen::VectorXd::Zero(equations.residual.size());
  for (size_t k = static_cast<size_t>(change.first_row); k < order.size(); ++k)
    later.segment(order[k] * size, size) =
        equations.columns.middleRows(order[k] * size, size) * change.moved;
  const Eigen::VectorXd left =
      equations.residual - later + equations.basis * (equations.basis.transpose() * later);
  return median_norm(left, size) < kNearer * median_norm(equations.residual, size);
}

std::vector<int> sorted_by(const std::vector<double>& keys) {
  std::vector<int> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int row) { return keys[static_cast<size_t>(row)]; });
  return order;
}

// Pose numbers by row; empty if an id is no number.
std::vector<double> pose_numbers(const Campaign& campaign) {
  std::vector<double> numbers;
  for (int pose : campaign.pose) {
    const std::string& id = campaign.pose_ids[static_cast<size_t>(pose)];
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

std::string place_of(const SetUpChange& change, const Order& order, const Campaign& campaign) {
  const auto row = static_cast<size_t>(order.rows[static_cast<size_t>(change.first_row)]);
  if (order.of == "time") return fmt::format("t_s = {:.10g}", campaign.time_s[row]);
  if (order.of == "pose")
    return "pose " + campaign.pose_ids[static_cast<size_t>(campaign.pose[row])];
  return fmt::format("line {}", campaign.line[row]);
}

std::string describe_base(const SetUpChange& change, const Order& order, const Robot& robot,
                          const Campaign& campaign) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : campaign.position) middle += point / campaign.rows();
  const Eigen::Vector3d turned = change.moved.tail<3>();
  const Eigen::Vector3d moved =
      change.moved.head<3>() + turned.cross(middle - robot.chain.base.translation);
  std::string by_time;
  if (order.of == "time") {
    const auto row = static_cast<size_t>(order.rows[static_cast<size_t>(change.first_row)]);
    by_time = fmt::format("--new-session-at-s {:.10g} or ", campaign.time_s[row]);
  }
  return fmt::format(
      "from {} on, in the order of the {}s, the readings lie in another frame, {:.3g} mm and "
      "{:.3g} mrad away: was the instrument moved? Then give {}a column 'session'",
      place_of(change, order, campaign), order.of, moved.norm() / kMillimetre,
      turned.norm() / kMilliradian, by_time);
}

std::string describe_tool(const SetUpChange& change, const Order& order, const Campaign& campaign) {
  std::string turned;
  if (change.moved.size() > 3)
    turned = fmt::format(" and {:.3g} mrad", change.moved.tail<3>().norm() / kMilliradian);
  return fmt::format(
      "from {} on, in the order of the {}s, the reflector is elsewhere on the tool, {:.3g} mm{} "
      "away: was the tool changed or the reflector seated anew? Then give a column 'target' with "
      "another name from there on, or calibrate the parts by themselves",
      place_of(change, order, campaign), order.of, change.moved.head<3>().norm() / kMillimetre,
      turned);
}

}  // namespace

std::optional<std::string> find_set_up_change(const PlainFit& fit) {
  const Campaign& sample = fit.readings;
  const Robot& robot = fit.result.robot;
  struct Place {
    int first, count;  // parameters
  };
  constexpr int kPose = 6, kPoint = 3;
  std::vector<Place> places{{kFirstBaseParameter, kPose}};
  if (sample.target_names.size() < 2)
    places.push_back({layout_of(robot.chain).tool, sample.has_orientation() ? kPose : kPoint});
  const std::vector<Order> orders = orders_of(sample);
  const auto choices = static_cast<double>(orders.size() * places.size());
  const double poses =
      static_cast<double>(std::set<int>(sample.pose.begin(), sample.pose.end()).size());
  const Order* found = nullptr;
  bool of_tool = false;
  SetUpChange best{.score = kClearFall};
  for (const Place& place : places) {
    std::vector<int> parameters(static_cast<size_t>(place.count));
    std::iota(parameters.begin(), parameters.end(), place.first);
    const FitEquations equations = fit_equations(fit, parameters);
    for (const Order& order : orders) {
      const SetUpChange change = best_place(equations, order.rows, poses, choices);
      if (change.score <= best.score || !is_of_most(change, equations, order.rows)) continue;
      best = change;
      found = &order;
      of_tool = place.first != kFirstBaseParameter;
    }
  }
  if (!found) return std::nullopt;
  return of_tool ? describe_tool(best, *found, sample) : describe_base(best, *found, robot, sample);
}

}  // namespace armtrue
