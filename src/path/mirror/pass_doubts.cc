#include "armtrue/path/mirror/pass_doubts.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "armtrue/path/low_pass.h"
#include "linear_algebra/decompositions.h"
#include "path/mirror/mean_deviation.h"
#include "statistics/rounding.h"

namespace armtrue {
namespace {

using Eigen::Index;

constexpr double kUnlike = 0.5;      // of the mean deviation
constexpr double kTimesNoise = 6;    // of a sample
constexpr double kClearly = 3;       // standard deviations
constexpr double kRounding = 1e-12;  // of the file, of the squared extents

// RMS length of the means of blocks of some columns.
double rms_of_blocks(const Eigen::Matrix3Xd& columns, Index length) {
  double square = 0;
  int blocks = 0;
  for (Index first = 0; first + length <= columns.cols(); first += length, ++blocks)
    square += columns.middleCols(first, length).rowwise().mean().squaredNorm();
  return blocks > 0 ? std::sqrt(square / blocks) : 0;
}

// The principal axes of the positions about their mean.
struct Extents {
  Extents(const Path& path, double off) {
    const Eigen::MatrixXd about_mean = path.position.colwise() - path.position.rowwise().mean();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(about_mean * about_mean.transpose(),
                                                Eigen::ComputeFullU);
    squared = svd.singularValues();
    axes = svd.matrixU();
    least = std::max(kRounding * squared[0], off * off * path.samples());
  }

  Eigen::Vector3d squared;  // sums along the axes, the largest first [m^2]
  Eigen::Matrix3d axes;
  double least;  // what stays within `off` (rms)
};

}  // namespace

std::optional<UnlikePass> find_unlike_pass(const Path& programmed, const std::vector<Path>& passes,
                                           const MirrorResult& result) {
  if (passes.size() < 2) return std::nullopt;
  std::vector<Path> good;
  for (size_t p = 0; p < passes.size(); ++p)
    good.push_back(without(passes[p], result.passes[p].bad));
  const PathDeviation& all = result.deviation;
  const Index second = std::clamp<Index>(std::lround(1 / all.period), 1, all.time.size());
  const double mean = rms_of_blocks(all.normal, second);
  const auto count = static_cast<double>(passes.size());
  std::optional<UnlikePass> found;
  for (size_t p = 0; p < passes.size(); ++p) {
    // Its distance from the mean of all is (count - 1) / count of that from the others.
    const ClockFit& clock = result.passes[p].clock;
    const auto at = [&](double time) {
      return std::lround((clock.program_time(time) - all.time[0]) / all.period);
    };
    const Index first = std::clamp<Index>(at(good[p].time[0]), 0, all.time.size()),
                last = std::clamp<Index>(at(good[p].time[good[p].samples() - 1]), first,
                                         all.time.size());
    const Eigen::Matrix3Xd off =
        (deviation_of_pass(programmed, good, result.passes, p).normal - all.normal)
            .middleCols(first, last - first);
    const double apart = count / (count - 1) * rms_of_blocks(off, second);
    if (apart <= std::max(kUnlike * mean, kTimesNoise * all.noise)) continue;
    constexpr double kFarther = 1 + 1e-9;  // of two passes both are as far
    if (!found || apart > kFarther * found->apart) found = UnlikePass{p, apart, mean};
  }
  return found;
}

namespace {

std::optional<ForceLaw> law_of_arm(const Path& programmed, const MirrorResult& result,
                                   const MirrorOptions& options,
                                   const std::array<Index, 3>& force_axes) {
  PathDeviation deviation = options.executed
                                ? from_executed(result.deviation, programmed, *options.executed)
                                : result.deviation;
  if (deviation.force.cols() == 0) return std::nullopt;
  deviation.force = deviation.force(force_axes, Eigen::all).eval();
  deviation.engagement.noise = deviation.engagement.noise(force_axes).eval();
  return force_law(deviation, programmed, position_at(programmed, deviation.time),
                   LowPass(options.order, result.cutoff, 1 / deviation.period));
}

}  // namespace

std::optional<std::pair<Index, Index>> exchanged_forces(const Path& programmed,
                                                        const MirrorResult& result,
                                                        const MirrorOptions& options) {
  constexpr double kTimesLess = 4, kMostUnexplained = 0.5;
  const auto given = law_of_arm(programmed, result, options, {0, 1, 2});
  if (!given) return std::nullopt;
  const auto follows = [](const ForceLine& line) { return line.k && line.k->ci95[0] > 0; };
  for (const auto& [a, b] : {std::pair<Index, Index>(0, 1), {0, 2}, {1, 2}}) {
    std::array<Index, 3> axes{0, 1, 2};
    std::swap(axes[a], axes[b]);
    const auto other = law_of_arm(programmed, result, options, axes);
    const auto explains = [&](Index axis) {
      const double left = 1 - other->axis[axis].r2;
      return follows(other->axis[axis]) && left < kMostUnexplained &&
             kTimesLess * left < 1 - given->axis[axis].r2;
    };
    if (explains(a) && explains(b)) return std::pair(a, b);
  }
  return std::nullopt;
}

bool deviates_against_force(const Path& programmed, const MirrorResult& result,
                            const MirrorOptions& options) {
  const auto law = law_of_arm(programmed, result, options, {0, 1, 2});
  if (!law || !law->directions[0].compliance) return false;
  const ForceDirection& strongest = law->directions[0];
  double value = 0, variance = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const double share = strongest.direction[axis];
    value += share * (*strongest.compliance)[axis].value;
    variance += std::pow(share * (*strongest.compliance)[axis].std, 2);
  }
  return value + kClearly * std::sqrt(variance) < 0;
}

bool hardly_deviates(const MirrorResult& result) {
  return result.before.rms <= result.deviation.noise;
}

std::optional<double> step_that_hides(const Path& record, double noise) {
  constexpr std::array kSteps{1e-3, 5e-4, 2.5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 2e-5, 1e-5};  // [m]
  for (const double step : kSteps) {
    int most = 0;  // a path along an axis shows few digits of the others
    bool is_rounded = true;
    for (Index axis = 0; axis < 3 && is_rounded; ++axis) {
      const auto row = record.position.row(axis);
      const auto digits = last_digits({row.begin(), row.end()}, step);
      is_rounded = digits.has_value();
      most = std::max(most, digits.value_or(0));
    }
    if (!is_rounded || most < kFewestLastDigits) continue;
    if (noise < step / 2) return step;
    return std::nullopt;
  }
  return std::nullopt;
}

bool deviates_as_before(const Path& programmed, const MirrorResult& result,
                        const Eigen::Matrix3Xd& executed) {
  // Of the correction that the deviation undoes, and of the squared deviation that is left then.
  constexpr double kLeastShare = 0.7, kMostShare = 1.3, kMostLeft = 0.25;
  Path run = programmed;
  run.position = executed;
  const Eigen::VectorXd& time = result.deviation.time;
  const Eigen::Matrix3Xd correction = position_at(run, time) - position_at(programmed, time);
  const Eigen::Matrix3Xd& trend = result.deviation.trend;
  const double square = correction.squaredNorm();
  if (square == 0) return false;
  const double share = -trend.cwiseProduct(correction).sum() / square;
  return share >= kLeastShare && share <= kMostShare &&
         (trend + share * correction).squaredNorm() < kMostLeft * trend.squaredNorm();
}

double longest_step_in_motion(const Path& path) {
  double longest = 0;
  for (Index i = 1; i < path.samples(); ++i)
    if (path.position.col(i) != path.position.col(i - 1))
      longest = std::max(longest, path.time[i] - path.time[i - 1]);
  return longest;
}

bool is_straight(const Path& path, double off) {
  const Extents extents(path, off);
  return extents.squared[1] <= extents.least;
}

std::optional<Eigen::Vector3d> normal_of_flat(const Path& path, double off) {
  const Extents extents(path, off);
  if (extents.squared[2] > extents.least) return std::nullopt;
  return extents.axes.col(2);
}

}  // namespace armtrue
