#include "armtrue/calibration/unseen_scale.h"

#include <algorithm>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

std::optional<UnseenScale> unseen_scale(const Robot& robot, const Campaign& campaign) {
  if (campaign.rows() == 0 || campaign.has_touches_only()) return std::nullopt;
  constexpr int kRowsAtOnce = 64;
  KinematicChain in_foot = robot.chain;
  in_foot.base = Pose{};
  const ChainEvaluator evaluator(in_foot);
  const std::vector<int> targets = match_targets(campaign, in_foot);
  Eigen::VectorXd distances(campaign.rows());
  std::vector<JointVector> q;
  std::vector<Pose> poses(kRowsAtOnce);
  for (int first = 0; first < campaign.rows(); first += kRowsAtOnce) {
    const int end = std::min(first + kRowsAtOnce, campaign.rows());
    q.assign(campaign.q.begin() + first, campaign.q.begin() + end);
    evaluator.poses(q, {}, std::span(poses).first(q.size()));
    for (int row = first; row < end; ++row) {
      const Pose& pose = poses[row - first];
      const int target = targets.empty() ? -1 : targets[campaign.target[row]];
      distances[row] =
          target < 0 ? pose.translation.norm() : (pose * in_foot.targets[target].position).norm();
    }
  }
  return UnseenScale{distances.mean(), distances.maxCoeff()};
}

}  // namespace armtrue
