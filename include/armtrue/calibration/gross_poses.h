#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A pose all of whose readings are off alike: a wrong target, a bumped reflector, joint angles of
/// another pose.
struct GrossPose {
  std::string id;
  std::vector<int> rows;  ///< that are off
  double off;             ///< mean distance from what a fit without the pose predicts [m]
  std::string likely;     ///< what would explain it, in words
};

/// Finds single poses that are off as a whole, which the law of the readings cannot see: there
/// each reading is judged against the others of its pose.
///
/// One reading stands for the replicates of a pose and channel, the nearest to their median. A pose
/// is judged by what the fit without it predicts: with r its whitened residuals, B their
/// derivatives in coordinates in which the information is the unit matrix, W their weights,
///     e = r + C W r,  S = I + C,  C = G (I - W G)^-1,  G = B B^T,  u^2 = e^T S^-1 e / (d s^2),
/// d the number of residuals. s^2 is the largest that the quantiles 0.5, 0.75 and 0.9 over the
/// poses give, so it holds what the model lacks, and its tails. Poses are gross if
///   - u^2, F-distributed, is less probable than 0.001 over the number of poses,
///   - they are off by more than 4 times the median length of an error with the fit's sigma,
///   - u is 1.5 times that of the first pose that is not gross (a tail of ordinary lack of fit has
///     no gap), 2.5 times where sigma is above 1.25 times the noise of replicates, and
///   - no joint has two of its four nearest poses off too, less probably than 0.001 over all
///     joints: a neighbourhood that is off is structure.
/// The fit is repeated without the gross poses, from a start under Student's t, until the set
/// stays. More than one pose in ten is taken for structure unless a mistake explains most of them.
/// Empty where the readings are too few to tell, and beyond 2000 poses, where one counts little.
/// `effects` of the robot are fitted too.
std::vector<GrossPose> find_gross_poses(const Robot& robot, const Campaign& campaign);

/// The rows of all of them, in ascending order.
std::vector<int> rows_of(const std::vector<GrossPose>& gross);

/// The campaign without the rows of gross poses.
Campaign without_gross(const Campaign& campaign, const std::vector<GrossPose>& gross);

/// The robot as it is met in a cell: only base and tool are set up on the readings.
Robot placed_nominal(const Robot& robot, const Campaign& campaign);

/// Throws std::invalid_argument, with remedy, if more readings are left out (gross poses and
/// blunders) than kept, or if the fit misses the kept ones by more (mean) than the nominal robot
/// with base and tool placed; the latter only where base and tool are identified. `sound`: the
/// campaign of the fit, of which it takes the rows `blunders` for blunders. Returns the nominal
/// robot as it was placed; nothing where base and tool are not both identified.
std::optional<Robot> require_worthwhile(const Robot& nominal, const CalibrationResult& fit,
                                        const Campaign& sound, const std::vector<int>& blunders,
                                        int gross_rows);

}  // namespace armtrue
