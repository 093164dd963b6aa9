#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/compensation/compensation.h"

namespace armtrue {

/// The uncertainty of the calibration at each row of a program.
struct Coverage {
  std::vector<double> deviation;  ///< as CorrectedTarget::deviation
  std::vector<double> leverage;   ///< as Prediction::leverage
  /// How far the point would lie elsewhere if the effects that may be the instrument's, and are
  /// not applied, were the arm's [m].
  std::vector<double> not_applied;
};

/// `visits`: q programmed, arrival known, force in the axes of R_0. Empty vectors if the robot does
/// not state its uncertainty.
Coverage coverage(const Robot& identified, const CompensationOptions& options,
                  const Campaign& visits);

}  // namespace armtrue
