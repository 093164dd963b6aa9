#include "path/registration/first_offset.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace armtrue {
namespace {

// Speed, as chord over `window` [s], at times `period` apart from the first sample on.
Eigen::VectorXd speed(const Path& path, double period, double window) {
  const double steps = std::ceil((path.time[path.samples() - 1] - path.time[0]) / period);
  const auto count = static_cast<Eigen::Index>(steps) + 1;
  const auto times = [&](double shift) -> Eigen::VectorXd {
    return Eigen::VectorXd::LinSpaced(count, path.time[0] + shift,
                                      path.time[0] + shift + period * steps);
  };
  return (position_at(path, times(window / 2)) - position_at(path, times(-window / 2)))
             .colwise()
             .norm()
             .transpose() /
         window;
}

// correlation[k] = sum_i a[i + k - (b.size() - 1)] b[i]
Eigen::VectorXd correlate(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index length = a.size() + b.size() - 1;
  Eigen::Index padded = 1;
  while (padded < length) padded *= 2;
  Eigen::FFT<double> fft;
  const auto transform = [&](const Eigen::VectorXd& values) {
    Eigen::VectorXd time = Eigen::VectorXd::Zero(padded);
    time.head(values.size()) = values;
    Eigen::VectorXcd frequency;
    fft.fwd(frequency, time);
    return frequency;
  };
  const Eigen::VectorXcd product = transform(a).cwiseProduct(transform(b.reverse()));
  Eigen::VectorXd correlation;
  fft.inv(correlation, product);
  return correlation.head(length);
}

}  // namespace

double mean_square_distance(const Path& programmed, const Path& measured, double offset,
                            double rate) {
  const Eigen::Index step = std::max(1, measured.samples() / 5000);
  const Eigen::VectorXd time = measured.time(Eigen::seq(0, Eigen::last, step));
  const Eigen::Matrix3Xd position = measured.position(Eigen::all, Eigen::seq(0, Eigen::last, step));
  return (position - position_at(programmed, (time.array() - offset) / (1 + rate)))
      .colwise()
      .squaredNorm()
      .mean();
}

double first_offset(const Path& programmed, const Path& measured) {
  const double period = median_period(measured);
  const double duration = programmed.time[programmed.samples() - 1] - programmed.time[0];
  const double window = std::max(3 * period, std::min(0.25, 0.05 * duration));
  const Eigen::VectorXd correlation =
      correlate(speed(measured, period, window), speed(programmed, period, window));
  const double last = std::ceil(duration / period);
  const auto offset_of = [&](Eigen::Index k) {
    return measured.time[0] - programmed.time[0] + (static_cast<double>(k) - last) * period;
  };
  // Candidates: the highest peaks (a raster fits again one line further), and offsets evenly spread
  // over all that are good (a stretch at constant speed fits anywhere). The right one is good:
  // drag, force and noise cost it less than 3 % of the best correlation.
  const double good = 0.97 * correlation.maxCoeff();
  std::vector<Eigen::Index> peaks, places;
  for (Eigen::Index k = 0; k < correlation.size(); ++k) {
    if (correlation[k] < good) continue;
    places.push_back(k);
    const Eigen::Index from = std::max<Eigen::Index>(k - 3, 0);
    const Eigen::Index to = std::min(k + 3, correlation.size() - 1);
    if (correlation[k] == correlation.segment(from, to - from + 1).maxCoeff()) peaks.push_back(k);
  }
  constexpr size_t kMaxTried = 100;  // of either; each costs a comparison of the positions
  const auto higher = [&](Eigen::Index a, Eigen::Index b) {
    return correlation[a] > correlation[b];
  };
  std::sort(peaks.begin(), peaks.end(), higher);
  peaks.resize(std::min(peaks.size(), kMaxTried));
  const double highest = offset_of(peaks.front());
  for (size_t k = 0; k < places.size(); k += std::max<size_t>(1, places.size() / kMaxTried))
    peaks.push_back(places[k]);
  double best = highest;
  double least = kMaxPathDistance * kMaxPathDistance;
  for (const Eigen::Index k : peaks) {
    const double offset = offset_of(k);
    const double here = mean_square_distance(programmed, measured, offset);
    if (here >= least) continue;
    least = here;
    best = offset;
  }
  return best;
}

ClockFit follow_drift(const Path& programmed, const Path& measured, ClockFit fit) {
  constexpr double kFirstDrift = 0.1;  // [s] over half of the first stretch
  constexpr int kRounds = 5;           // of Gauss and Newton, from a start close by
  constexpr Eigen::Index kMaxSamples = 5000;
  const auto begin = measured.time.begin(), end = measured.time.end();
  const double middle = 0.5 * (*begin + *(end - 1)), whole = *(end - 1) - middle;
  for (double half = kFirstDrift / kRateSigma;; half *= 2) {
    const auto first = std::lower_bound(begin, end, middle - half) - begin;
    const auto last = std::upper_bound(begin, end, middle + half) - begin - 1;
    const auto some =
        Eigen::seq(first, last, std::max<Eigen::Index>(1, (last - first) / kMaxSamples));
    const Eigen::VectorXd time = measured.time(some);
    const Eigen::Matrix3Xd position = measured.position(Eigen::all, some);
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::VectorXd own = (time.array() - fit.offset) / (1 + fit.rate);
      const Eigen::Matrix3Xd velocity = velocity_at(programmed, own);
      const Eigen::Matrix3Xd off = position - position_at(programmed, own);
      const double at = fit.program_time(middle);
      Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      for (Eigen::Index i = 0; i < own.size(); ++i) {
        const Eigen::Vector2d by(1, own[i] - at);
        normal += velocity.col(i).squaredNorm() * by * by.transpose();
        right -= velocity.col(i).dot(off.col(i)) * by;
      }
      const Eigen::Vector2d change = normal.ldlt().solve(right);
      if (!change.allFinite()) return fit;
      fit.offset += change[0] - at * change[1];
      fit.rate += change[1];
    }
    if (half >= whole) return fit;
  }
}

}  // namespace armtrue
