#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/observation/fold.h"
#include "armtrue/observation/session_models.h"
#include "calibration/prior.h"

namespace armtrue {

/// The solver's last fold of one group of rows, and its x. If the last step was accepted, this x is
/// the solution, and the statistics need no other fold.
struct GroupFold {
  Eigen::VectorXd x;
  Fold folded;
};

struct Solution {
  bool converged = false;
  int iterations = 0;
  std::string termination;       ///< message of the solver
  std::vector<GroupFold> folds;  ///< of each group, under the fixed sigma and law
};

/// Second derivatives of a step where first derivatives are kept. With those of the first step
/// later ones cost nothing, and a few short steps end at the same minimum.
enum class Curvature { of_each_step, of_first_step };

/// Minimises over x, by Levenberg-Marquardt (Ceres), with sigma and law held fixed,
///     sum over the rows of ReadingLaw::loss + sum over the priors of ((start + x) / deviation)^2.
/// `x`: the start, and on return the solution. `kept`: of each group, by normal equations; empty:
/// the derivatives are those at each step.
Solution minimise(const SessionModels& models, const ReadingLaw& law,
                  const std::vector<Prior>& priors, int max_iterations, double tolerance, FoldBy by,
                  Eigen::VectorXd& x, const std::vector<KeptDerivatives>& kept = {},
                  Curvature curvature = Curvature::of_each_step);

}  // namespace armtrue
