#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/calibration/prediction.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/campaign/split.h"

namespace armtrue {

/// The residuals of a campaign, one for each row.
struct Residuals {
  const Campaign& campaign;
  std::vector<Eigen::Matrix<double, 6, 1>> of_row;  ///< as in Evaluation [m, rad]
  std::vector<std::string> split;                   ///< of each row: training, held-out or all
  std::vector<Prediction> predictions{};  ///< of each row; empty if the robot has no uncertainty
};

/// CSV of the residuals, measured minus model, in R_A; the residual of a distance is in the column
/// dl_mm. The rows of the campaigns follow one another.
std::string write_residuals(const std::vector<Residuals>& campaigns);

/// The residuals of a robot on a campaign that was split, then on the poses of another file, all
/// held out; `test` may be empty.
std::string write_residuals(const Robot& robot, const Campaign& all, const Split& split,
                            const Campaign& test);

}  // namespace armtrue
