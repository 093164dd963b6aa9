#include "armtrue/diagnosis/suspicions.h"

#include <algorithm>

#include "diagnosis/frame_change.h"
#include "diagnosis/plain_fit.h"
#include "diagnosis/scale_check.h"

namespace armtrue {

std::vector<std::string> find_suspicions(const Robot& robot, const Campaign& campaign) {
  if (!robot.sessions.empty() ||
      (!campaign.session.empty() && std::ranges::max(campaign.session) > 0))
    return {};
  const auto fit = fit_plainly(robot, campaign);
  if (!fit) return {};
  std::vector<std::string> found;
  const auto add = [&found](const std::optional<std::string>& suspicion) {
    if (suspicion) found.push_back(*suspicion);
  };
  if (campaign.has_distances())
    add(find_scale_of_anchor(*fit));
  else
    add(find_frame_change(*fit));
  if (found.empty()) add(find_scale_of_links(*fit, robot));
  return found;
}

}  // namespace armtrue
