#include "armtrue/calibration/pose_bootstrap.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "armtrue/statistics/distributions.h"
#include "armtrue/statistics/summary.h"
#include "calibration/pose_influence.h"

namespace armtrue {

Eigen::MatrixXd drawn_sums(const Eigen::MatrixXd& by_pose, int draws, std::uint64_t seed) {
  constexpr int kDrawsAtOnce = 64;  // bounds the memory of many poses
  std::mt19937_64 random(seed);
  const auto poses = static_cast<std::uint64_t>(by_pose.rows());
  Eigen::MatrixXd sums(draws, by_pose.cols());
  for (int first = 0; first < draws; first += kDrawsAtOnce) {
    const int count = std::min(kDrawsAtOnce, draws - first);
    Eigen::MatrixXd times = Eigen::MatrixXd::Zero(count, by_pose.rows());
    for (int draw = 0; draw < count; ++draw)
      for (std::uint64_t k = 0; k < poses; ++k) times(draw, random() % poses) += 1;
    sums.middleRows(first, count) = times * by_pose;
  }
  return sums;
}

std::array<double, 2> percentile_interval(std::vector<double> values, int poses) {
  if (poses < 2 || values.empty()) return {0, 0};
  const double wide = student_t_975(poses - 1) * std::sqrt(poses / (poses - 1.0));
  const double share = normal_below(-wide);
  const double place = share * (static_cast<double>(values.size()) - 1);
  const auto below = static_cast<std::ptrdiff_t>(place + 0.5);
  const auto low = values.begin() + below, high = values.end() - 1 - below;
  std::nth_element(values.begin(), low, values.end());
  if (high > low) std::nth_element(low + 1, high, values.end());
  return {*low, *high};
}

Eigen::MatrixXd bootstrap_coefficients(const CalibrationResult& fit, const Campaign& campaign,
                                       int draws, std::uint64_t seed) {
  const SessionModels models(campaign, fit.robot, fit.set.kept, fit.sigma);
  const Eigen::MatrixXd& root = fit.inverse_root;
  const auto of_coefficients =
      root.middleRows(models.geometric_count(), models.first_own(1) - models.geometric_count());
  std::vector<Eigen::VectorXd> changes;
  for_each_pose<std::vector<Eigen::VectorXd>>(
      models.at(Eigen::VectorXd::Zero(models.unknowns())), fit.weights, root,
      grouped_rows(campaign.pose_by_id()),
      [&](std::vector<Eigen::VectorXd>& block, const PoseInfluence& pose, const auto&,
          const auto&) { block.push_back(of_coefficients * pose.change); },
      [&](const std::vector<Eigen::VectorXd>& block) {
        changes.insert(changes.end(), block.begin(), block.end());
      });
  const auto poses = static_cast<int>(changes.size());
  Eigen::MatrixXd influence(poses, of_coefficients.rows());
  for (int pose = 0; pose < poses; ++pose) influence.row(pose) = changes[pose].transpose();
  influence.rowwise() -= influence.colwise().mean().eval();
  const double firm = mean_psi_derivative(fit.weights, fit.degrees_of_freedom, models.row_size());
  return (poses - 1) / (poses * firm) * drawn_sums(influence, draws, seed);
}

std::array<double, 2> interval_about(const Eigen::VectorXd& bootstrap_draws, double deviation,
                                     int poses) {
  const double drawn =
      std::sqrt(bootstrap_draws.squaredNorm() * poses /
                (static_cast<double>(bootstrap_draws.size()) * std::max(1, poses - 1)));
  const double wide = student_t_975(poses - 1) * deviation;
  if (!(drawn > 0)) return {-wide, wide};
  const auto [low, high] =
      percentile_interval({bootstrap_draws.begin(), bootstrap_draws.end()}, poses);
  return {low / drawn * deviation, high / drawn * deviation};
}

void set_intervals(const Eigen::MatrixXd& bootstrap_draws, int poses, Robot& robot) {
  Eigen::Index k = 0;
  for (Effect& effect : robot.effects)
    for (Coefficient& c : effect.coefficients) {
      const auto [low, high] = interval_about(bootstrap_draws.col(k++), c.std, poses);
      c.ci95 = {c.value + low, c.value + high};
    }
}

}  // namespace armtrue
