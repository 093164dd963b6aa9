#include "armtrue/campaign/stated_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace armtrue {

bool add_covariance(const PoseCovariance& covariance, const StatedBlocks& blocks,
                    Campaign& campaign) {
  const double position = std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3);
  const double rotation = std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
  Eigen::Matrix<double, 6, 1> deviation;
  deviation << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(rotation);
  const PoseCovariance shape =
      deviation.cwiseInverse().asDiagonal() * covariance * deviation.cwiseInverse().asDiagonal();
  const Eigen::LLT<PoseCovariance> llt(shape);
  if (!(position > 0) || !(rotation > 0) || llt.info() != Eigen::Success) return false;
  if (blocks.position) campaign.sigma_position.push_back(position);
  if (blocks.rotation) campaign.sigma_orientation.push_back(rotation);
  campaign.whitening.emplace_back(llt.matrixL().solve(PoseCovariance::Identity()));
  return true;
}

StatedBlocks stated_blocks(const Campaign& campaign) {
  if (campaign.whitening.empty()) return {};
  return {!campaign.sigma_position.empty(), !campaign.sigma_orientation.empty()};
}

PoseCovariance stated_covariance(const Campaign& campaign, int row) {
  const size_t index = row;
  const StatedBlocks blocks = stated_blocks(campaign);
  PoseCovariance root = campaign.whitening[index].inverse();
  root.topRows<3>() *= blocks.position ? campaign.sigma_position[index] : 1.0;
  root.bottomRows<3>() *= blocks.rotation ? campaign.sigma_orientation[index] : 1.0;
  return root * root.transpose();
}

}  // namespace armtrue
