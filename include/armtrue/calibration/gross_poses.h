#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// A pose whose readings all share one large error: a wrong target, a bumped reflector, joint
/// angles of another pose.
struct GrossPose {
  std::string id;
  std::vector<int> rows;  ///< with the error
  double off;             ///< mean distance from what a fit without the pose predicts [m]
  std::string likely;     ///< probable cause, in words
  bool is_explained = false;  ///< by a mistake whose correction makes the readings fit
};

/// Finds single poses whose readings all share one large error. The robust weights of calibrate()
/// may miss them, because they judge each reading by itself.
///
/// Of the replicates of a pose and channel, the one nearest to their median is used. Each pose is
/// compared with the prediction of the fit without it. With r its whitened residuals, B their
/// derivatives in coordinates in which the information is the unit matrix, and W their weights,
///     e = r + C W r,  S = I + C,  C = G (I - W G)^-1,  G = B B^T,  u^2 = e^T S^-1 e / (d s^2),
/// with d the number of residuals. s^2 is the largest of the estimates from the quantiles 0.5, 0.75
/// and 0.9 of u^2 over the poses, so it includes the lack of fit of the model and its tails. Poses
/// are gross if
///   - the p of u^2, which is F-distributed, is below 0.001 / (number of poses),
///   - the error of a quarter of their readings exceeds 4 times the median length of an error with
///     the sigma of the fit (half of the corners of an image, along u or v; not a single corner),
///   - u is 1.5 times that of the first pose that is not gross (a tail of ordinary lack of fit has
///     no gap), 2.5 times where sigma is above 1.25 times the noise of replicates, and
///   - their error is 5 mm or more, or their neighbours are not off too: if for some joint two of
///     the four nearest poses are off, with a probability below 0.001 over all joints and by a
///     fifth of its u, the model lacks something there.
/// The fit is repeated without the gross poses, from a start under Student's t, until the set
/// stays. At most a quarter of the poses are gross. If more than 10 % are, the model lacks
/// something and none is, unless one kind of mistake explains half of them. Empty if there are too
/// few readings to decide, and beyond 2000 poses, where one pose matters little. The effects of the
/// robot are fitted too. Poses that a shift of one contact, target or anchor explains together have
/// the same words.
std::vector<GrossPose> find_gross_poses(const Robot& robot, const Campaign& campaign);

/// The same among readings that took no part in the fit of `robot`, which must state its
/// uncertainty. A pose is gross if the RMS of its errors over their predicted deviations
/// (Prediction::deviation) is above 8, and above 8 times the median of the poses; that of points is
/// then 14 standard deviations of an axis. Where the model lacks something, poses may be as far
/// off: so a mistake must explain it, or it must be 5 mm or more. None if more than half of
/// the poses are as far off, or beyond 2000 poses; at most 50.
std::vector<GrossPose> find_gross_held_out(const Robot& robot, const Campaign& held_out);

/// The rows of all gross poses, in ascending order.
std::vector<int> rows_of(const std::vector<GrossPose>& gross);

/// The campaign without the rows of gross poses.
Campaign without_gross(const Campaign& campaign, const std::vector<GrossPose>& gross);
/// The same, where `gross` counts the rows of `training`, or all rows if that is empty.
Campaign without_gross(const Campaign& all, const std::vector<int>& training,
                       const std::vector<GrossPose>& gross);

}  // namespace armtrue
