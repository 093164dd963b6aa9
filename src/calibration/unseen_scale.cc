#include "armtrue/calibration/unseen_scale.h"

#include <algorithm>

#include "armtrue/calibration/registration.h"

namespace armtrue {

std::optional<UnseenScale> unseen_scale(const Robot& robot, const Campaign& campaign) {
  if (campaign.rows() == 0 || campaign.has_touches_only()) return std::nullopt;
  Robot in_foot = robot;
  in_foot.chain.base = Pose{};
  in_foot.sessions.clear();
  const Eigen::VectorXd distances = own_points(in_foot, campaign).colwise().norm();
  return UnseenScale{distances.mean(), distances.maxCoeff()};
}

}  // namespace armtrue
