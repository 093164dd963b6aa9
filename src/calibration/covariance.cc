#include "calibration/covariance.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "armtrue/statistics/distributions.h"
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

// The equation of a prior in the coordinates of the root: adds factor * l l^T, l the row of its
// unknown divided by its deviation.
void add_known(const Prior& prior, const Eigen::MatrixXd& root, double factor,
               Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd known = root.row(prior.unknown).transpose() / prior.deviation;
  covariance += factor * known * known.transpose();
}

void add_known(const Prior& prior, const SparseRows& root, double factor,
               Eigen::MatrixXd& covariance) {
  const double weight = factor / (prior.deviation * prior.deviation);
  for (SparseRows::InnerIterator a(root, prior.unknown); a; ++a)
    for (SparseRows::InnerIterator b(root, prior.unknown); b; ++b)
      covariance(b.col(), a.col()) += weight * a.value() * b.value();
}

// root * covariance * root^T
Eigen::MatrixXd of_unknowns(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& root) {
  return root * covariance * root.transpose();
}

// Column by column of the dense side: fast with the sparse one on the right. Of many unknowns each
// matrix is large: no more than two at once.
Eigen::MatrixXd of_unknowns(Eigen::MatrixXd covariance, const SparseRows& root) {
  covariance = covariance * root.transpose();
  covariance.transposeInPlace();
  return covariance * root.transpose();
}

// CR2 of a pose that gives one number: its residual divided by the root of 1 - h, not by 1 - h.
PoseInfluence unbiased(const PoseInfluence& pose, const Eigen::Ref<const Eigen::MatrixXd>& row) {
  return {pose.change * std::sqrt(std::max(0.0, 1 - row.squaredNorm())), pose.alone};
}

// (t(n) / t(poses - 1))^2
double widening(double n, int poses) {
  const double t = student_t_975(std::round(n));
  return std::pow(t / student_t_975(poses - 1), 2);
}

// `Root`: dense or sparse.
template <typename Root>
Eigen::MatrixXd by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                        const Eigen::VectorXd& x, const std::vector<double>& weights,
                        double degrees_of_freedom, const Root& root, double variance,
                        const std::optional<SingleNumbers>& single) {
  if (root.cols() == 0) return Eigen::MatrixXd::Zero(root.rows(), root.rows());
  const GroupedRows all = grouped_rows(models.campaign().pose);
  const GroupedRows some = some_poses(all, kPosesForCovariance);
  struct Sums {
    InfluenceSums influence;
    SumOfSquares information;
  } sums{InfluenceSums(root.cols()), {}};
  const bool is_part = some.groups() < all.groups();
  for_each_pose<Sums>(
      models.at(x), weights, root, some,
      [&](Sums& block, const PoseInfluence& pose, const auto& rows, const auto& coordinates) {
        block.influence.add(single ? unbiased(pose, rows) : pose, coordinates, root.cols());
        if (is_part) block.information.add(rows.transpose(), coordinates);
      },
      [&](const Sums& block) {
        sums.influence.add(block.influence);
        sums.information.add(block.information);
      });
  Eigen::MatrixXd covariance = sums.influence.covariance(
      mean_psi_derivative(weights, degrees_of_freedom, models.row_size()), variance);
  if (is_part) covariance = of_all_poses(covariance, sums.information.dense(root.cols()), variance);
  sums = {};
  if (single) covariance *= single->of_readings;
  for (size_t k = 0; k < priors.size(); ++k)
    add_known(priors[k], root, single ? single->of_priors[k] : 1.0, covariance);
  return of_unknowns(std::move(covariance), root);
}

}  // namespace

std::optional<SingleNumbers> single_numbers(const SessionModels& models, const Priors& priors,
                                            const Eigen::VectorXd& share_of_readings,
                                            double freedom) {
  const int poses = grouped_rows(models.campaign().pose).groups();
  if (models.row_size() > 1 || poses != models.rows() || poses < 2) return std::nullopt;
  // The deviations of poses about their mean count with poses - 1.
  SingleNumbers single{widening(freedom, poses) * poses / (poses - 1.0), {}};
  std::map<int, double> determined;
  for (const Prior& prior : priors.of_unknowns)
    determined[prior.width] += share_of_readings[prior.unknown];
  for (const Prior& prior : priors.of_unknowns) {
    if (prior.width < 0) {
      single.of_priors.push_back(1);
      continue;
    }
    const double spread = priors.widths[prior.width].log_spread;
    const double known = determined[prior.width] + 0.5 / (spread * spread);
    single.of_priors.push_back(std::max(1.0, widening(known, poses)));
  }
  return single;
}

Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const Eigen::MatrixXd& root,
                                   double variance, const std::optional<SingleNumbers>& single) {
  return by_pose(models, priors, x, weights, degrees_of_freedom, root, variance, single);
}

Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const SparseRows& root,
                                   double variance, const std::optional<SingleNumbers>& single) {
  return by_pose(models, priors, x, weights, degrees_of_freedom, root, variance, single);
}

}  // namespace armtrue
