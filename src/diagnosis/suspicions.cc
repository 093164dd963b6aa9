#include "armtrue/diagnosis/suspicions.h"

#include <algorithm>

#include "armtrue/calibration/gross_poses.h"
#include "diagnosis/impossible_change.h"
#include "diagnosis/plain_fit.h"
#include "diagnosis/rounding_check.h"
#include "diagnosis/scale_check.h"
#include "diagnosis/set_up_change.h"

namespace armtrue {

LogFindings find_suspicions(const Robot& robot, const Campaign& campaign) {
  LogFindings found;
  if (!robot.sessions.empty() ||
      (!campaign.session.empty() && std::ranges::max(campaign.session) > 0))
    return found;
  auto fit = fit_plainly(robot, campaign);
  if (!fit) return found;
  auto change = find_impossible_change(robot, fit->result);
  if (change)
    // Least squares follow a gross pose as far: they say something of the others only.
    if (const auto gross = find_gross_poses(robot, campaign); !gross.empty()) {
      fit = fit_plainly(robot, without_gross(campaign, gross));
      if (!fit) return found;
      change = find_impossible_change(robot, fit->result);
    }
  if (change) {
    found.errors.push_back(*change);
    return found;
  }
  auto suspicion = campaign.has_distances() ? find_scale_of_anchor(*fit) : find_set_up_change(*fit);
  if (!suspicion) suspicion = find_scale_of_links(*fit, robot);
  if (!suspicion) suspicion = find_rounded_angles(*fit);
  if (suspicion) found.warnings.push_back(*suspicion);
  return found;
}

}  // namespace armtrue
