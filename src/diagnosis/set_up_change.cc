#include "diagnosis/set_up_change.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "diagnosis/changed_cause.h"
#include "diagnosis/reading_order.h"

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

// The readings of the equations in an order of the rows.
std::vector<int> readings_in(const ReadingOrder& order, const FitEquations& equations) {
  std::vector<int> place(order.rows.size()), readings(equations.rows.size());
  for (size_t k = 0; k < place.size(); ++k) place[order.rows[k]] = static_cast<int>(k);
  std::iota(readings.begin(), readings.end(), 0);
  std::ranges::stable_sort(readings, {}, [&](int k) { return place[equations.rows[k].front()]; });
  return readings;
}

// `last`: row of the last reading before the change; `first`: of the first one after it.
ChangedPart part_of(int last, int first, const ReadingOrder& order, const Campaign& campaign) {
  if (!campaign.has_pixels_only()) return parts_from({first}, order, campaign);
  const auto pose = [&](int row) { return campaign.pose_ids[campaign.pose[row]]; };
  return {fmt::format("between the images of pose {} and pose {}, in the order of the {}s,",
                      pose(last), pose(first), order.of),
          ""};
}

std::string words_of(const Cause& cause, const KinematicChain& chain) {
  switch (cause.kind) {
    case Cause::Kind::base:
      return "the frame of the readings";
    case Cause::Kind::tool:
      return "the place of the reflector on the tool";
    case Cause::Kind::zero:
      return "the zero of " + chain.links[link_of_parameter(cause.parameter)].name;
    case Cause::Kind::contact:
      return "the place of a camera or a board";
    default:
      return "the scale of the instrument";
  }
}

// The fall of BIC by a cause that changes evenly in an order of the readings, in place of at once.
double fall_by_drift(const FitEquations& equations, const Cause& cause,
                     const std::vector<int>& order, double poses, double choices) {
  const int size = equations.row_size;
  const auto rows = static_cast<double>(order.size());
  Eigen::MatrixXd columns = equations.columns.middleCols(cause.first_column, cause.count);
  for (size_t k = 0; k < order.size(); ++k)
    columns.middleRows(order[k] * size, size) *= static_cast<double>(k) / rows;
  return fall_of_bic(fit_beside(columns, equations), equations, poses, choices * rows);
}

}  // namespace

std::optional<Suspicion> find_set_up_change(const PlainFit& fit) {
  const Campaign& sample = fit.readings;
  const Causes causes = possible_causes(fit, true);
  const double poses = fit.poses();
  const FitEquations equations = reading_equations(fit, causes.parameters);
  const std::vector<ReadingOrder> orders = orders_of(sample);
  const auto choices = static_cast<double>(orders.size() * causes.all.size());
  const ReadingOrder* found = nullptr;
  const Cause* found_cause = nullptr;
  SetUpChange best{.score = kClearFall};
  for (const ReadingOrder& order : orders) {
    const std::vector<int> readings = readings_in(order, equations);
    for (const Cause& cause : causes.all) {
      const SetUpChange change = best_place(equations, cause, readings, poses, choices);
      if (change.score <= best.score ||
          !is_of_most(explained_by(change, equations, cause, readings), equations))
        continue;
      best = change;
      found = &order;
      found_cause = &cause;
    }
  }
  if (!found) return std::nullopt;
  const std::vector<int> readings = readings_in(*found, equations);
  if (fall_by_drift(equations, *found_cause, readings, poses, choices) > best.score)
    return Suspicion{
        best.score,
        fmt::format("in the order of the {}s {} changes evenly, rather than at once: a drift or a "
                    "warm-up, which close-loop looks for where the readings have times (t_s)",
                    found->of, words_of(*found_cause, fit.result.robot.chain))};
  const auto row_of = [&](int k) { return equations.rows[readings[k]].front(); };
  return Suspicion{best.score, describe_change(*found_cause, best.moved, fit,
                                               part_of(row_of(best.first - 1), row_of(best.first),
                                                       *found, sample))};
}

}  // namespace armtrue
