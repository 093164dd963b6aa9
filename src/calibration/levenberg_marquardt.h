#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/fold.h"
#include "calibration/prior.h"
#include "calibration/session_models.h"

namespace armtrue {

/// A fold of one session and its point x. If the last step was accepted, the last fold of the
/// solver is at the solution, and the statistics can use it.
struct SessionFold {
  Eigen::VectorXd x;
  ReadingSigma sigma;
  ReadingLaw law;
  Fold folded;

  bool is_at(const Eigen::VectorXd& other, const ObservationModel& model,
             const ReadingLaw& other_law) const {
    return x.size() == other.size() && x == other && sigma.position == model.sigma().position &&
           sigma.orientation == model.sigma().orientation && law == other_law;
  }
};

struct Solution {
  bool converged = false;
  int iterations = 0;
  std::string termination;         ///< message of the solver
  std::vector<SessionFold> folds;  ///< the last of each session
};

/// Minimises over x, by Levenberg-Marquardt (Ceres), with sigma and law held fixed,
///     sum over the rows of ReadingLaw::loss + sum over the priors of ((start + x) / deviation)^2.
/// `x`: the start, and on return the solution. `kept`: derivatives of each session, for normal
/// equations; if empty, they are computed at each step.
Solution minimise(const SessionModels& models, const ReadingLaw& law,
                  const std::vector<Prior>& priors, int max_iterations, double tolerance, FoldBy by,
                  Eigen::VectorXd& x, const std::vector<KeptDerivatives>& kept = {});

}  // namespace armtrue
