#include "path/mirror/trend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/low_pass.h"
#include "armtrue/statistics/summary.h"
#include "path/smoothing_spline.h"

namespace armtrue {
namespace {

double duration(const Eigen::VectorXd& time) { return time[time.size() - 1] - time[0]; }

// Stein's estimate for a trend that kept the share `kept` of the noise.
double expected_square(const PathDeviation& deviation, const Eigen::Matrix3Xd& trend, double kept) {
  const double left = (deviation.normal - trend).colwise().squaredNorm().mean();
  const double noise = 2 * deviation.noise * deviation.noise;
  return std::max(left - noise + 2 * noise * kept, noise * kept);
}

double samples_of(const PathDeviation& deviation) {
  return static_cast<double>(deviation.time.size());
}

double pieces_of(const PathDeviation& deviation) {
  return static_cast<double>(deviation.breaks.size() + 1);
}

// Share of the noise that piecewise smoothing keeps: each piece has a free constant.
double kept_piecewise(const PathDeviation& deviation, double share) {
  return share + pieces_of(deviation) / samples_of(deviation);
}

// Share of the noise that polygons keep: a vertex is free in two components, and in its place along
// the path unless it ends a piece.
double kept_by_polygon(const PathDeviation& deviation, size_t points) {
  const auto all = static_cast<double>(points);
  const double inner = all - 2 * pieces_of(deviation);
  return (all + inner / 2) / samples_of(deviation);
}

// A long record reduced to runs of samples, evenly spread: they determine the cut-off as well.
PathDeviation thinned(const PathDeviation& deviation) {
  constexpr Eigen::Index kRuns = 20, kRun = 2000;
  const Eigen::Index count = deviation.time.size();
  PathDeviation some;
  some.period = deviation.period;
  some.noise = deviation.noise;
  some.time.resize(kRuns * kRun);
  some.normal.resize(3, kRuns * kRun);
  for (Eigen::Index run = 0; run < kRuns; ++run) {
    const Eigen::Index from = run * (count - kRun) / (kRuns - 1), to = run * kRun;
    some.time.segment(to, kRun) = deviation.time.segment(from, kRun);
    some.normal.middleCols(to, kRun) = deviation.normal.middleCols(from, kRun);
    if (run > 0) some.breaks.push_back(to);
    for (const Eigen::Index b : deviation.breaks)
      if (b > from && b < from + kRun) some.breaks.push_back(b - from + to);
  }
  return some;
}

// The cut-off with the least expected error, from a grid.
double best_cutoff(const PathDeviation& deviation, const MirrorOptions& options) {
  constexpr Eigen::Index kMaxSamples = 100000;
  if (deviation.time.size() > kMaxSamples) return best_cutoff(thinned(deviation), options);
  const double rate = 1 / deviation.period;
  const double lowest = std::max(0.1, 2 / duration(deviation.time)), highest = 0.25 * rate;
  double best = lowest, least = std::numeric_limits<double>::infinity();
  for (double cutoff = lowest; cutoff < highest; cutoff *= 1.25) {
    const Smoother low_pass = smoother(options, cutoff, rate);
    const double here =
        expected_square(deviation, smooth(deviation.normal, deviation.breaks, low_pass),
                        kept_piecewise(deviation, low_pass.noise_share));
    if (here >= least) continue;
    least = here;
    best = cutoff;
  }
  return best;
}

}  // namespace

Smoother smoother(const MirrorOptions& options, double cutoff, double rate) {
  if (options.points == CorrectionPoints::spline)
    return {[=](const Eigen::MatrixXd& samples) { return smoothing_spline(samples, cutoff, rate); },
            smoothing_spline_noise_share(cutoff, rate)};
  const LowPass filter(options.order, cutoff, rate);
  return {filter, filter.noise_share()};
}

void check_lowest(double cutoff, const Eigen::VectorXd& time) {
  if (cutoff * duration(time) >= 1) return;
  std::array<char, 200> message{};
  std::snprintf(message.data(), message.size(),
                "a cut-off of %.4g Hz has a period of %.4g s, longer than the %.4g s of the pass: "
                "nothing of it would be left; it has to be above %.4g Hz",
                cutoff, 1 / cutoff, duration(time), 1 / duration(time));
  throw std::invalid_argument(message.data());
}

double choose_cutoff(const PathDeviation& deviation, const MirrorOptions& options) {
  if (!options.cutoff) return best_cutoff(deviation, options);
  check_lowest(*options.cutoff, deviation.time);
  return *options.cutoff;
}

std::vector<std::pair<Eigen::Index, Eigen::Index>> pieces(const std::vector<Eigen::Index>& breaks,
                                                          Eigen::Index samples) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> all{{0, samples}};
  for (const Eigen::Index b : breaks) {
    all.back().second = b;
    all.emplace_back(b, samples);
  }
  return all;
}

Eigen::Matrix3Xd smooth(const Eigen::Matrix3Xd& samples, const std::vector<Eigen::Index>& breaks,
                        const Smoother& smoother) {
  Eigen::Matrix3Xd trend(3, samples.cols());
  for (const auto& [begin, end] : pieces(breaks, samples.cols()))
    trend.middleCols(begin, end - begin) = smoother.smooth(samples.middleCols(begin, end - begin));
  return trend;
}

double expected_square(const PathDeviation& deviation, CorrectionPoints how, size_t points,
                       double noise_share) {
  return expected_square(deviation, deviation.trend,
                         how == CorrectionPoints::turning ? kept_by_polygon(deviation, points)
                                                          : kept_piecewise(deviation, noise_share));
}

}  // namespace armtrue
