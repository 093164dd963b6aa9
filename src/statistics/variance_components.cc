#include "statistics/variance_components.h"

#include <algorithm>
#include <cmath>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr int kMaxSteps = 100;
constexpr double kTolerance = 0.01;  // of ln tau and ln s: their doubt is far larger
constexpr double kMostOfStep = 1.5;  // of ln tau
constexpr double kLeastTau = 1e-4;   // of what is usual: such a group adds nothing

// With D the diagonal of tau, M = s^2 I + D Z'^T Z' D.
struct Posterior {
  Eigen::VectorXd mean;     // D M^-1 D Z'^T r'
  Eigen::VectorXd inverse;  // diagonal of s^2 M^-1
  double log_determinant;   // of M / s^2
  double left;              // r'^T r' - r'^T Z' mean
};

Posterior posterior(const MixedModelSums& sums, const Eigen::VectorXd& tau, double noise) {
  const double variance = noise * noise;
  Eigen::MatrixXd m = tau.asDiagonal() * sums.zz * tau.asDiagonal();
  m.diagonal().array() += variance;
  const Eigen::LLT<Eigen::MatrixXd> factor(m);
  const Eigen::MatrixXd& lower = factor.matrixLLT();
  Posterior result;
  result.mean = tau.cwiseProduct(factor.solve(Eigen::MatrixXd(tau.cwiseProduct(sums.zr))).col(0));
  result.log_determinant = 2 * lower.diagonal().array().log().sum() -
                           static_cast<double>(tau.size()) * std::log(variance);
  result.left = sums.rr - sums.zr.dot(result.mean);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(m.rows(), m.cols());
  lower.triangularView<Eigen::Lower>().solveInPlace(inverse);
  result.inverse = variance * inverse.colwise().squaredNorm().transpose();
  return result;
}

}  // namespace

VarianceComponents restricted_likelihood(const MixedModelSums& sums,
                                         const std::vector<VarianceGroup>& groups,
                                         const Eigen::VectorXd& start) {
  VarianceComponents result;
  const auto count = static_cast<Eigen::Index>(groups.size());
  result.tau = start.size() > 0 ? start : Eigen::VectorXd::Ones(count);
  const double noise_alone = std::sqrt(sums.rr / sums.freedom);
  result.noise = start.size() > 0 ? noise_alone : 0.7 * noise_alone;
  Eigen::VectorXd tau(sums.zr.size());
  double log_likelihood = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    for (Eigen::Index g = 0; g < count; ++g)
      tau.segment(groups[g].first, groups[g].count).setConstant(result.tau[g]);
    const Posterior at = posterior(sums, tau, result.noise);
    result.mean = at.mean;
    const double variance = result.noise * result.noise;
    log_likelihood = -0.5 * (sums.freedom * std::log(variance) + at.log_determinant +
                             at.left / variance);
    double determined = 0, change = 0;
    for (Eigen::Index g = 0; g < count; ++g) {
      const VarianceGroup& group = groups[g];
      const double of_group =
          static_cast<double>(group.count) - at.inverse.segment(group.first, group.count).sum();
      determined += of_group;
      const double squares = at.mean.segment(group.first, group.count).squaredNorm();
      // d/d(ln tau): squares / tau^2 - of_group - ln tau / log_spread^2 = 0, by Newton's step in
      // ln tau of the left side with `of_group` held.
      const double precision = 1 / (group.log_spread * group.log_spread);
      double log_tau = std::log(result.tau[g]);
      const double before = log_tau;
      for (int k = 0; k < 50; ++k) {
        const double pull = squares * std::exp(-2 * log_tau);
        const double newton = (pull - of_group - precision * log_tau) / (2 * pull + precision);
        log_tau += std::clamp(newton, -1.0, 1.0);
        if (std::abs(newton) < 1e-6) break;
      }
      log_tau = std::clamp(log_tau, before - kMostOfStep, before + kMostOfStep);
      log_tau = std::max(log_tau, std::log(kLeastTau));
      change = std::max(change, std::abs(log_tau - before) * std::min(1.0, std::sqrt(of_group)));
      result.tau[g] = std::exp(log_tau);
    }
    const Eigen::VectorXd fitted = sums.zz * at.mean;
    const double rest = sums.rr - 2 * sums.zr.dot(at.mean) + at.mean.dot(fitted);
    const double noise = std::sqrt(std::max(rest, 1e-12 * sums.rr) /
                                   std::max(1.0, sums.freedom - determined));
    change = std::max(change, std::abs(std::log(noise / result.noise)));
    result.noise = noise;
    if (change < kTolerance) break;
  }
  const double alone =
      -0.5 * (sums.freedom * std::log(noise_alone * noise_alone) + sums.freedom);
  result.gain = 2 * (log_likelihood - alone);
  return result;
}

}  // namespace armtrue
