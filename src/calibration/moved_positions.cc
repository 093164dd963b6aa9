#include "calibration/moved_positions.h"

namespace armtrue {
namespace {

std::optional<Campaign> without_covariances(const Campaign& campaign) {
  if (campaign.whitening.empty()) return std::nullopt;
  Campaign by_axis = campaign;
  by_axis.whitening.clear();
  return by_axis;
}

}  // namespace

MovedPositions::MovedPositions(const Robot& robot, const Campaign& campaign,
                               const std::vector<int>& geometric, const Eigen::MatrixXd& root,
                               const RootsOfSessions& of_sessions)
    : by_axis_(without_covariances(campaign)),
      models_(by_axis_ ? *by_axis_ : campaign, robot, geometric, {1.0, 1.0}, kAllEffects,
              SessionModels::Split::by_target),
      root_(root),
      of_sessions_(of_sessions),
      axes_(campaign.reading_size().position) {}

MovedPositions::OwnRoot MovedPositions::root_of(int group) const {
  OwnRoot own;
  std::vector<Eigen::Index> rows;
  const auto further = of_sessions_.find(models_.name(models_.session_of(group)));
  const Eigen::MatrixXd& root = further == of_sessions_.end() ? root_ : further->second;
  const std::vector<int> in_root = models_.in_first_session(group);
  for (size_t k = 0; k < in_root.size(); ++k) {
    if (in_root[k] < 0 || in_root[k] >= root.rows()) continue;
    own.unknowns.push_back(k);
    rows.push_back(in_root[k]);
  }
  own.rows = root(rows, Eigen::all);
  return own;
}

}  // namespace armtrue
