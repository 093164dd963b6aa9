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
                               const std::vector<int>& geometric, const Eigen::MatrixXd& root)
    : by_axis_(without_covariances(campaign)),
      models_(by_axis_ ? *by_axis_ : campaign, robot, geometric, {1.0, 1.0}, kAllEffects,
              SessionModels::Split::by_target),
      root_(root),
      axes_(campaign.reading_size().position) {}

Eigen::MatrixXd MovedPositions::root_of(int group) const {
  const Eigen::Index count = std::min<Eigen::Index>(models_.model(group).unknowns(), root_.rows());
  if (!models_.is_split_by_target()) return root_.topRows(count);
  std::vector<Eigen::Index> unknowns;
  for (const SessionModels::Run& run : models_.runs(group))
    for (Eigen::Index k = run.first; k < run.first + run.count; ++k)
      if (k < root_.rows()) unknowns.push_back(k);
  return root_(unknowns, Eigen::all);
}

}  // namespace armtrue
