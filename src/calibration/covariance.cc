#include "calibration/covariance.h"

#include <Eigen/Core>

#include "calibration/pose_influence.h"
#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kPosesForCovariance = 16384;  // tell a standard deviation to half a per cent

// The covariance of a fit to all poses, from that of some of them. Both, and the information of
// those, are in coordinates in which the information of all is the unit matrix. A direction that
// the poses taken hardly show, because only few of all poses do, gets the variance of its readings.
Eigen::MatrixXd of_all_poses(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& information,
                             double variance) {
  constexpr double kShown = 0.1;  // of what they show on average
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const Eigen::VectorXd& shares = eigen.eigenvalues();
  const auto shown = (shares.array() > kShown * shares.mean()).eval();
  const Eigen::VectorXd inverse_root_of_share =
      shown.select(shares.cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), 0);
  const Eigen::MatrixXd turned =
      inverse_root_of_share.asDiagonal() * eigen.eigenvectors().transpose();
  Eigen::MatrixXd scaled = turned * covariance * turned.transpose();
  scaled.diagonal() += shown.select(Eigen::VectorXd::Zero(shares.size()), variance).matrix();
  return eigen.eigenvectors() * scaled * eigen.eigenvectors().transpose();
}

// The equation of a prior in the coordinates of the root: adds l l^T, l the row of its unknown
// divided by its deviation.
void add_known(const Prior& prior, const Eigen::MatrixXd& root, Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd known = root.row(prior.unknown).transpose() / prior.deviation;
  covariance += known * known.transpose();
}

void add_known(const Prior& prior, const SparseRows& root, Eigen::MatrixXd& covariance) {
  const double weight = 1 / (prior.deviation * prior.deviation);
  for (SparseRows::InnerIterator a(root, prior.unknown); a; ++a)
    for (SparseRows::InnerIterator b(root, prior.unknown); b; ++b)
      covariance(b.col(), a.col()) += weight * a.value() * b.value();
}

// root * covariance * root^T
Eigen::MatrixXd of_unknowns(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& root) {
  return root * covariance * root.transpose();
}

Eigen::MatrixXd of_unknowns(const Eigen::MatrixXd& covariance, const SparseRows& root) {
  const Eigen::MatrixXd half = root * covariance;
  const Eigen::MatrixXd turned = half.transpose();  // the product is fast with the sparse side left
  return root * turned;
}

// `Root`: dense or sparse.
template <typename Root>
Eigen::MatrixXd by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                        const Eigen::VectorXd& x, const std::vector<double>& weights,
                        double degrees_of_freedom, const Root& root, double variance) {
  if (root.cols() == 0) return Eigen::MatrixXd::Zero(root.rows(), root.rows());
  const RowsByPose all = rows_by_pose(models.campaign().pose);
  const RowsByPose some = some_poses(all, kPosesForCovariance);
  struct Sums {
    InfluenceSums influence;
    Eigen::MatrixXd information;
  } sums{{}, Eigen::MatrixXd::Zero(root.cols(), root.cols())};
  const bool is_part = some.poses() < all.poses();
  for_each_pose<Sums>(
      models.at(x), weights, root, some,
      [&](Sums& block, const PoseInfluence& pose, const auto& rows) {
        block.influence.add(pose);
        if (!is_part) return;
        if (block.information.size() == 0)
          block.information = Eigen::MatrixXd::Zero(root.cols(), root.cols());
        block.information.noalias() += rows.transpose() * rows;
      },
      [&](const Sums& block) {
        sums.influence.add(block.influence);
        if (is_part) sums.information += block.information;
      });
  Eigen::MatrixXd covariance = sums.influence.covariance(
      mean_psi_derivative(weights, degrees_of_freedom, models.row_size()), variance);
  if (is_part) covariance = of_all_poses(covariance, sums.information, variance);
  for (const Prior& prior : priors) add_known(prior, root, covariance);
  return of_unknowns(covariance, root);
}

}  // namespace

Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const Eigen::MatrixXd& root,
                                   double variance) {
  return by_pose(models, priors, x, weights, degrees_of_freedom, root, variance);
}

Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const SparseRows& root,
                                   double variance) {
  return by_pose(models, priors, x, weights, degrees_of_freedom, root, variance);
}

}  // namespace armtrue
