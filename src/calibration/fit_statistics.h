#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "calibration/levenberg_marquardt.h"
#include "calibration/prior.h"
#include "calibration/reading_law.h"
#include "calibration/session_models.h"

namespace armtrue {

/// J^T W J of all rows: unknowns x unknowns.
Eigen::MatrixXd joint_information(const SessionModels& models,
                                  const std::vector<GroupFold>& folds);

/// How many of the unknowns positions and orientations determine: tr J (J_all^T J_all + P)^-1 J^T,
/// J of that kind, P of the priors. With many equations, in proportion to their numbers, which
/// leaves sigma right to 3 %.
Eigen::Array2d determined_by(const SessionModels& model, Eigen::MatrixXd information,
                             const Priors& priors, const Eigen::VectorXd& x);

/// Sets what the solution x says of itself: names, weights, spread, determined, the priors'
/// equations, inverse_root, covariance, share_of_readings, rank, condition and observability.
/// `folds`: those of the solution, if they may be used for statistics.
void set_statistics(const SessionModels& model, const ReadingLaw& law, const Priors& all_priors,
                    const Eigen::VectorXd& x, std::vector<GroupFold> folds,
                    CalibrationResult& result);

/// What set_statistics() sets for a step of a search: names, weights, spread and determined.
void set_weights_alone(const SessionModels& model, const ReadingLaw& law, const Priors& priors,
                       const Eigen::VectorXd& x, const std::vector<GroupFold>& folds,
                       CalibrationResult& result);

}  // namespace armtrue
