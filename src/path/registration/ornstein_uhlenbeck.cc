#include "path/registration/ornstein_uhlenbeck.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "linear_algebra/decompositions.h"

namespace armtrue {
namespace {

constexpr double kBlunder = 5;
constexpr Eigen::Index kLongestForLaw = 2048;

}  // namespace

Whitened whiten(const DeviationLaw& law, const AxisSamples& samples) {
  const double power = law.deviation * law.deviation;
  const double noise = law.noise * law.noise;
  const double jump = law.jump * law.jump;
  Whitened white{samples.columns};
  double variance = power;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(white.columns.cols());
  Eigen::RowVectorXd innovation(white.columns.cols());
  for (Eigen::Index i = 0; i < samples.time.size(); ++i) {
    if (i > 0) {
      const double kept = std::exp(-(samples.time[i] - samples.time[i - 1]) / law.correlation_time);
      mean *= kept;
      variance = kept * kept * variance + (1 - kept * kept) * power + jump * samples.share[i];
    }
    const double scale = 1 / std::sqrt(variance + noise);
    innovation = white.columns.row(i) - mean;
    if (std::abs(innovation[0]) * scale > kBlunder) {
      white.columns.row(i).setZero();
      white.log_determinant += 0.5 * kBlunder * kBlunder - std::log(scale);
      ++white.blunders;
      continue;
    }
    mean += variance * scale * scale * innovation;
    variance *= noise * scale * scale;
    white.columns.row(i) = scale * innovation;
    white.log_determinant -= std::log(scale);
  }
  return white;
}

double cost(const DeviationLaw& law, const AxisSamples& samples, double* best_scale) {
  const Whitened white = whiten(law, samples);
  double total = white.log_determinant;
  Eigen::VectorXd rest = white.columns.col(0);
  auto free = static_cast<double>(rest.size() - white.blunders);
  const auto regressors = white.columns.rightCols(white.columns.cols() - 1);
  if (!regressors.isZero(0)) {
    // Restricted: otherwise what the regressors take would look like less deviation.
    const auto solver = regressors.colPivHouseholderQr();
    rest -= regressors * solver.solve(rest);
    free -= static_cast<double>(solver.rank());
    total += solver.matrixR().diagonal().head(solver.rank()).cwiseAbs().array().log().sum();
  }
  if (free < 1) return std::numeric_limits<double>::infinity();
  if (!best_scale) return total + 0.5 * rest.squaredNorm();
  const double size = rest.squaredNorm() / free;
  *best_scale = std::sqrt(size);
  return total + 0.5 * free * std::log(std::max(size, std::numeric_limits<double>::min()));
}

DeviationLaw fit_law(const AxisSamples& samples) {
  // A law is a matter of a few hundred samples; the rest of a long record would only take time.
  const Eigen::Index count = std::min(samples.time.size(), kLongestForLaw);
  const Eigen::Index begin = (samples.time.size() - count) / 2;
  const AxisSamples some{samples.time.segment(begin, count), samples.share.segment(begin, count),
                         samples.columns.middleRows(begin, count)};
  const double duration = some.time[count - 1] - some.time[0];
  // Nothing is read to less than this [m]; a simulated record without noise must not divide by
  // zero.
  constexpr double kFinest = 1e-7;
  const double typical =
      std::max(kFinest, std::sqrt(some.columns.col(0).squaredNorm() / static_cast<double>(count)));
  DeviationLaw best;
  double least = std::numeric_limits<double>::infinity();
  // The overall size follows in closed form, so a grid over the other two suffices.
  for (double time = 4 * duration / static_cast<double>(count); time < 2 * duration; time *= 1.6) {
    for (double ratio = 0.05; ratio < 60; ratio *= 1.6) {  // deviation : noise
      const double noise = typical / std::sqrt(1 + ratio * ratio);
      double scale = 1;
      const double here = cost({ratio * noise, time, noise}, some, &scale);
      if (here >= least) continue;
      least = here;
      best = {scale * ratio * noise, time, std::max(scale * noise, kFinest)};
    }
  }
  return best;
}

}  // namespace armtrue
