#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/observation/reading_law.h"
#include "armtrue/observation/session_models.h"
#include "calibration/levenberg_marquardt.h"
#include "calibration/prior.h"

namespace armtrue {

/// J^T W J of all rows: unknowns x unknowns.
Eigen::MatrixXd joint_information(const SessionModels& models, const std::vector<GroupFold>& folds);

/// Number of unknowns that the positions and the orientations determine: tr J (J_all^T J_all +
/// P)^-1 J^T, with J the rows of that kind and P the information of the priors. With many equations
/// it is divided between the kinds by their numbers of equations, which gives sigma to 3 %.
Eigen::Array2d determined_by(const SessionModels& model, const Eigen::MatrixXd& information,
                             const Priors& priors, const Eigen::VectorXd& x);

/// Sets the names of the unknowns and the statistics of the solution x, those of
/// FitStatistics::information or all. `folds`: those of the solution, if they may be used for
/// statistics.
void set_statistics(const SessionModels& model, const ReadingLaw& law, const Priors& all_priors,
                    const Eigen::VectorXd& x, std::vector<GroupFold> folds,
                    FitStatistics statistics, CalibrationResult& result);

/// Sets the names and FitStatistics::weights.
void set_weights_alone(const SessionModels& model, const ReadingLaw& law, const Priors& priors,
                       const Eigen::VectorXd& x, const std::vector<GroupFold>& folds,
                       CalibrationResult& result);

}  // namespace armtrue
