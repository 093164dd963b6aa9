#include "armtrue/identification/pose_bootstrap.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "ordered_blocks.h"
#include "sessions.h"

namespace armtrue {
namespace {

constexpr double kOnlyThere = 1e-6;  // share of a direction that other poses show too
constexpr int kPosesPerBlock = 32;

std::vector<std::vector<int>> rows_by_pose(const Campaign& campaign) {
  const std::vector<int> pose = campaign.pose_by_id();
  std::vector<std::vector<int>> rows(campaign.pose_ids.size());
  for (int row = 0; row < campaign.rows(); ++row) rows[pose[row]].push_back(row);
  std::erase_if(rows, [](const std::vector<int>& of_pose) { return of_pose.empty(); });
  return rows;
}

// Under Student's t the sum of weights overstates how firmly the readings hold the fit: a reading
// that moves away is held less. Mean of d(w r)/dr over that of w (Huber 1981, 7.6); 1 if Gaussian.
double firmness(const CalibrationResult& fit, int dimension) {
  const double dof = fit.degrees_of_freedom;
  if (dof <= 0) return 1;
  double held = 0, weights = 0;
  for (double w : fit.weights) {
    const double far = 1 - dof * w / (dof + dimension);  // s / (dof + s) of a squared norm s
    held += w * (1 - 2.0 / dimension * far);
    weights += w;
  }
  return held / weights;
}

// What each pose does to the unknowns from `first` on: the fit with it less the fit without it.
// poses x count.
Eigen::MatrixXd influence_of_poses(const CalibrationResult& fit, const Campaign& campaign,
                                   Eigen::Index first, Eigen::Index count) {
  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.scale);
  const int size = models.row_size();
  Eigen::MatrixXd blocks = models.blocks();
  for (int row = 0; row < campaign.rows(); ++row)
    blocks.middleRows(row * size, size) *= std::sqrt(fit.weights[row]);
  const Eigen::Index p = blocks.cols() - 1;
  const double unit_variance =
      std::max(1.0, blocks.col(p).squaredNorm() / static_cast<double>(blocks.rows()));
  const Eigen::MatrixXd inverse = fit.covariance / unit_variance;
  const double firm = firmness(fit, size);

  const std::vector<std::vector<int>> poses = rows_by_pose(campaign);
  Eigen::MatrixXd influence(static_cast<Eigen::Index>(poses.size()), count);
  for_ordered_blocks<int>(
      static_cast<int>(poses.size()), kPosesPerBlock,
      [&](int begin, int end) {
        for (int pose = begin; pose < end; ++pose) {
          Eigen::MatrixXd own(static_cast<Eigen::Index>(poses[pose].size()) * size, p + 1);
          for (size_t i = 0; i < poses[pose].size(); ++i)
            own.middleRows(static_cast<Eigen::Index>(i) * size, size) =
                blocks.middleRows(poses[pose][i] * size, size);
          if (own.rows() > p + 1)
            own = Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(own)
                                      .matrixQR()
                                      .topRows(p + 1)
                                      .triangularView<Eigen::Upper>());
          const auto columns = own.leftCols(p);
          const Eigen::MatrixXd response = inverse * columns.transpose();
          // The residual that the pose would have if it took no part: (1 - leverage)^-1 of its own.
          Eigen::MatrixXd left = -columns * response;
          left.diagonal().array() += 1;
          const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(left);
          const Eigen::VectorXd shares = eigen.eigenvalues();
          const Eigen::VectorXd inverted =
              (shares.array() > kOnlyThere).select(shares.cwiseInverse(), 0.0);
          const Eigen::VectorXd residual = eigen.eigenvectors() * inverted.asDiagonal() *
                                           eigen.eigenvectors().transpose() * own.col(p);
          influence.row(pose) = (response.middleRows(first, count) * residual).transpose() / firm;
        }
        return 0;
      },
      [](int) {});
  return influence;
}

}  // namespace

Eigen::MatrixXd drawn_poses(int poses, int draws, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd drawn = Eigen::MatrixXd::Zero(draws, poses);
  for (int draw = 0; draw < draws; ++draw)
    for (int k = 0; k < poses; ++k)
      drawn(draw, static_cast<Eigen::Index>(random() % static_cast<std::uint64_t>(poses))) += 1;
  return drawn;
}

std::array<double, 2> percentile_interval(std::vector<double> values, int poses) {
  if (poses < 2 || values.empty()) return {0, 0};
  const double freedom = poses - 1;
  const double wide =
      boost::math::quantile(boost::math::students_t(freedom), 0.975) * std::sqrt(poses / freedom);
  const double share = boost::math::cdf(boost::math::normal(), -wide);
  std::sort(values.begin(), values.end());
  const double place = share * (static_cast<double>(values.size()) - 1);
  const auto below = static_cast<size_t>(place + 0.5);
  return {values[below], values[values.size() - 1 - below]};
}

Eigen::MatrixXd bootstrap_coefficients(const CalibrationResult& fit, const Campaign& campaign,
                                       int draws, std::uint64_t seed) {
  Eigen::Index count = 0;
  for (const Effect& effect : fit.robot.effects)
    count += static_cast<Eigen::Index>(effect.coefficients.size());
  Eigen::MatrixXd influence =
      influence_of_poses(fit, campaign, static_cast<Eigen::Index>(fit.set.kept.size()), count);
  influence.rowwise() -= influence.colwise().mean().eval();
  const double poses = static_cast<double>(influence.rows());
  return (poses - 1) / poses * drawn_poses(static_cast<int>(influence.rows()), draws, seed) *
         influence;
}

Spread spread_of(const Eigen::VectorXd& departures, int poses) {
  const double mean_square = departures.squaredNorm() / static_cast<double>(departures.size());
  const auto [low, high] = percentile_interval({departures.begin(), departures.end()}, poses);
  return {std::sqrt(mean_square * poses / std::max(1, poses - 1)), low, high};
}

void set_intervals(const Eigen::MatrixXd& departures, int poses, Robot& robot) {
  Eigen::Index k = 0;
  for (Effect& effect : robot.effects)
    for (Coefficient& c : effect.coefficients) {
      const Spread spread = spread_of(departures.col(k++), poses);
      c.std = spread.std;
      c.ci95 = {c.value + spread.low, c.value + spread.high};
    }
}

}  // namespace armtrue
