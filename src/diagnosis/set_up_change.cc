#include "diagnosis/set_up_change.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/changed_cause.h"
#include "diagnosis/reading_order.h"

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

}  // namespace

std::optional<Suspicion> find_set_up_change(const PlainFit& fit) {
  const Campaign& sample = fit.readings;
  const Causes causes = possible_causes(fit, true);
  const std::vector<ReadingOrder> orders = orders_of(sample);
  const auto choices = static_cast<double>(orders.size() * causes.all.size());
  const double poses = fit.poses();
  const FitEquations equations = fit_equations(fit, causes.parameters);
  const ReadingOrder* found = nullptr;
  const Cause* found_cause = nullptr;
  SetUpChange best{.score = kClearFall};
  for (const Cause& cause : causes.all)
    for (const ReadingOrder& order : orders) {
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
                   describe_change(*found_cause, best.moved, fit,
                                   parts_from({found->rows[best.first_row]}, *found, sample))};
}

}  // namespace armtrue
