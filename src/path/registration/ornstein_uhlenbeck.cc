#include "path/registration/ornstein_uhlenbeck.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kBlunderThreshold = 5;  // standard deviations of an innovation
constexpr Eigen::Index kMaxSamplesOfFit = 2048;

// A process times `scale` (deviation and noise), and what it costs.
struct ScaledCost {
  double cost = std::numeric_limits<double>::infinity();
  double scale = 1;
};

// Minus the logarithm of the restricted likelihood of the process at its best scale, which follows
// in closed form: scale^2 = |rest|^2 / (samples - blunders - rank of the regressors).
ScaledCost cost_at_best_scale(const OrnsteinUhlenbeck& process, const AxisSamples& samples) {
  const Whitened white = whiten(process, samples);
  double total = white.log_determinant;
  Eigen::VectorXd rest = white.columns.col(0);
  auto free = static_cast<double>(rest.size() - white.blunders);
  const Eigen::MatrixXd regressors = white.columns.rightCols(white.columns.cols() - 1);
  if (!regressors.isZero(0)) {
    // The unrestricted likelihood would take what the regressors explain for less deviation.
    const auto solver = regressors.colPivHouseholderQr();
    rest -= regressors * solver.solve(rest);
    free -= static_cast<double>(solver.rank());
    total += solver.matrixR().diagonal().head(solver.rank()).cwiseAbs().array().log().sum();
  }
  if (free < 1) return {};
  const double square = rest.squaredNorm() / free;
  return {total + 0.5 * free * std::log(std::max(square, std::numeric_limits<double>::min())),
          std::sqrt(square)};
}

// Coefficients of least squares. A process is meant that is scaled to all of the deviation: by one
// that is scaled to the rest, much of what the regressors explain would be a blunder.
Eigen::VectorXd least_squares(const OrnsteinUhlenbeck& process, const AxisSamples& samples) {
  const Whitened white = whiten(process, samples);
  return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(
             white.columns.rightCols(white.columns.cols() - 1))
      .solve(Eigen::VectorXd(white.columns.col(0)));
}

}  // namespace

Whitened whiten(const OrnsteinUhlenbeck& process, const AxisSamples& samples) {
  const double power = process.deviation * process.deviation;
  const double noise = process.noise * process.noise;
  const double jump = process.jump * process.jump;
  Whitened white{samples.columns};
  double variance = power;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(white.columns.cols());
  Eigen::RowVectorXd innovation(white.columns.cols());
  Eigen::VectorXd unexplained = Eigen::VectorXd::Unit(white.columns.cols(), 0);
  unexplained.segment(1, samples.explained.size()) = -samples.explained;
  for (Eigen::Index i = 0; i < samples.time.size(); ++i) {
    if (i > 0) {
      const double kept =
          std::exp(-(samples.time[i] - samples.time[i - 1]) / process.correlation_time);
      mean *= kept;
      variance = kept * kept * variance + (1 - kept * kept) * power + jump * samples.jump_share[i];
    }
    const double weight = 1 / std::sqrt(variance + noise);
    innovation = white.columns.row(i) - mean;
    if (std::abs(innovation.dot(unexplained)) * weight > kBlunderThreshold) {
      white.columns.row(i).setZero();
      white.log_determinant += 0.5 * kBlunderThreshold * kBlunderThreshold - std::log(weight);
      ++white.blunders;
      continue;
    }
    mean += variance * weight * weight * innovation;
    variance *= noise * weight * weight;
    white.columns.row(i) = weight * innovation;
    white.log_determinant -= std::log(weight);
  }
  return white;
}

FittedProcess fit_ornstein_uhlenbeck(const AxisSamples& samples) {
  // A few hundred samples determine the process; more would only take time.
  const Eigen::Index count = std::min(samples.time.size(), kMaxSamplesOfFit);
  const Eigen::Index begin = (samples.time.size() - count) / 2;
  const AxisSamples some{samples.time.segment(begin, count),
                         samples.jump_share.segment(begin, count),
                         samples.columns.middleRows(begin, count), samples.explained};
  const double duration = some.time[count - 1] - some.time[0];
  // [m]: no instrument reads more finely. A simulated record has no noise at all.
  constexpr double kMinNoise = 1e-7;
  const auto samples_of_fit = static_cast<double>(count);
  const double typical =
      std::max(kMinNoise, std::sqrt(some.columns.col(0).squaredNorm() / samples_of_fit));
  OrnsteinUhlenbeck best, unscaled;
  double least = std::numeric_limits<double>::infinity();
  // A grid over correlation time and deviation : noise; the overall scale follows in closed form.
  for (double time = 4 * duration / samples_of_fit; time < 2 * duration; time *= 1.6) {
    for (double ratio = 0.05; ratio < 60; ratio *= 1.6) {
      const double noise = typical / std::sqrt(1 + ratio * ratio);
      const OrnsteinUhlenbeck process{ratio * noise, time, noise};
      const auto [cost, scale] = cost_at_best_scale(process, some);
      if (cost >= least) continue;
      least = cost;
      unscaled = process;
      best = {scale * ratio * noise, time, std::max(scale * noise, kMinNoise)};
    }
  }
  return {best, least_squares(unscaled, samples)};
}

}  // namespace armtrue
