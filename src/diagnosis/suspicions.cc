#include "armtrue/diagnosis/suspicions.h"

#include <algorithm>

#include "diagnosis/frame_change.h"
#include "diagnosis/impossible_change.h"
#include "diagnosis/plain_fit.h"
#include "diagnosis/scale_check.h"

namespace armtrue {

LogFindings find_suspicions(const Robot& robot, const Campaign& campaign) {
  LogFindings found;
  if (!robot.sessions.empty() ||
      (!campaign.session.empty() && std::ranges::max(campaign.session) > 0))
    return found;
  const auto fit = fit_plainly(robot, campaign);
  if (!fit) return found;
  if (const auto change = find_impossible_change(robot, fit->result)) {
    found.errors.push_back(*change);
    return found;
  }
  auto suspicion =
      campaign.has_distances() ? find_scale_of_anchor(*fit) : find_frame_change(*fit);
  if (!suspicion) suspicion = find_scale_of_links(*fit, robot);
  if (suspicion) found.warnings.push_back(*suspicion);
  return found;
}

}  // namespace armtrue
