#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/observation/fold.h"
#include "armtrue/observation/session_models.h"
#include "calibration/prior.h"

namespace armtrue {

/// The solver's last fold of one group of rows and the x of it. It is at the solution if the last
/// step was accepted, and need then not be repeated for the statistics.
struct GroupFold {
  Eigen::VectorXd x;
  Fold folded;
};

struct Solution {
  bool converged = false;
  int iterations = 0;
  std::string termination;       ///< the solver's own words
  std::vector<GroupFold> folds;  ///< of each group, under the sigma and the law that were held
};

/// Whose second derivatives a step takes where first derivatives are kept. Those of the first step
/// cost the later ones nothing; a few short steps end at the same minimum with them.
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
