#include "planning/image_poses.h"

#include <algorithm>
#include <string>
#include <utility>

#include "armtrue/campaign/views.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/observation/contacts.h"

namespace armtrue {
namespace {

constexpr int kMostCorners = 12;  // of a board; more show the same of a pose, with less noise
constexpr double kEdge = 5;       // px, in which no corner is found

}  // namespace

Campaign image_readings(const PoseCloud& cloud, const std::vector<PlannedPose>& poses) {
  const KinematicChain& chain = cloud.robot.chain;
  const ChainEvaluator evaluator(chain);
  Campaign campaign;
  campaign.source = "the poses to be planned";
  campaign.metre_per_pixel = 1;
  const std::vector<View> views = views_of(chain);
  std::vector<int> first_name;  // of each view
  for (const View& view : views) {
    first_name.push_back(static_cast<int>(campaign.contact_names.size()));
    for (std::string& name : corner_names(chain, view))
      campaign.contact_names.push_back(std::move(name));
  }
  for (int pose = 0; pose < std::ssize(poses); ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose + 1));
    const Pose measured = evaluator.pose(poses[pose].q);
    for (size_t v = 0; v < views.size(); ++v) {
      const auto count = static_cast<int>(chain.contacts[views[v].board].points.size());
      const int used = std::min(count, kMostCorners);
      for (int k = 0; k < used; ++k) {
        const int point = k * (count - 1) / (used - 1);
        if (!shows(chain, views[v], measured, point, kEdge)) continue;
        const Eigen::Vector2d pixel = pixel_of(chain, views[v], measured, point);
        campaign.pose.push_back(pose);
        campaign.line.push_back(pose + 1);
        campaign.q.push_back(poses[pose].q);
        campaign.position.emplace_back(pixel.x(), pixel.y(), 0);
        campaign.distance.push_back(0);
        campaign.touch.push_back({first_name[v] + point, -1, true});
      }
    }
  }
  bind_touches(campaign, chain);
  return campaign;
}

}  // namespace armtrue
