#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

// Iterations that move joint angles until an error is least or zero. Each step solves the linear
// model of the error, which holds for small changes only, so no step moves a joint by more than
// kMaxJointStep.

inline constexpr double kMaxJointStep = 0.3;  // [rad], [m]

/// The step, shortened until no joint moves by more than kMaxJointStep.
inline JointVector shortened(JointVector step) {
  const double largest = step.cwiseAbs().maxCoeff();
  if (largest > kMaxJointStep) step *= kMaxJointStep / largest;
  return step;
}

/// J^T (J J^T + damping I)^-1 error: of the steps that make the change `error` in the linear model,
/// but for the damping, the smallest one. Types of fixed size stay of that size.
template <typename Jacobian, typename Error>
JointVector smallest_step(const Jacobian& jacobian, const Error& error, double damping) {
  constexpr int kRows = Jacobian::RowsAtCompileTime;
  using Normal = Eigen::Matrix<double, kRows, kRows>;
  using Step =
      Eigen::Matrix<double, Jacobian::ColsAtCompileTime, 1, 0, Jacobian::MaxColsAtCompileTime, 1>;
  const Normal normal = jacobian * jacobian.transpose() +
                        damping * Normal::Identity(jacobian.rows(), jacobian.rows());
  const Step step = jacobian.transpose() * normal.ldlt().solve(error);
  return step;
}

/// Start and limits of levenberg().
struct LevenbergLimits {
  int max_steps;          ///< accepted or not
  double first_damping;   ///< of the normal equations
  double max_damping;     ///< ends where the damping reaches this
  double least_step = 0;  ///< ends where no joint moves by this much [rad], [m]
};

/// Levenberg's method: a step that lowers the cost is taken, and the next is damped by a tenth as
/// much; otherwise the same is tried with ten times the damping. `Problem` has
///     double cost() const                       at its present joint angles
///     bool is_solved() const
///     JointVector step(double damping) const    (J^T J + damping I)^-1 J^T e there
///     double try_step(const JointVector& step)  the cost after a step
///     void accept(const JointVector& step)      makes it: the last that was tried
template <typename Problem>
void levenberg(Problem& problem, const LevenbergLimits& limits) {
  constexpr double kMinDamping = 1e-15;
  double cost = problem.cost(), damping = limits.first_damping;
  for (int k = 0; k < limits.max_steps && damping < limits.max_damping && !problem.is_solved();
       ++k) {
    const JointVector step = shortened(problem.step(damping));
    if (step.cwiseAbs().maxCoeff() < limits.least_step) return;
    const double next = problem.try_step(step);
    if (!(next < cost)) {
      damping *= 10;
      continue;
    }
    problem.accept(step);
    cost = next;
    damping = std::max(0.1 * damping, kMinDamping);
  }
}

/// Newton's method: takes the steps of `step_at` from `q`, until it returns none because the joint
/// angles are a solution. Nothing if `max_steps` do not lead to one.
template <typename StepAt>
std::optional<JointVector> newton(JointVector q, int max_steps, const StepAt& step_at) {
  for (int k = 0; k < max_steps; ++k) {
    const std::optional<JointVector> step = step_at(q);
    if (!step) return q;
    q += shortened(*step);
  }
  return std::nullopt;
}

}  // namespace armtrue
