#include "armtrue/path/mirror/engagement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/statistics/summary.h"

namespace armtrue {
namespace {

// Levels of entry and exit, in standard deviations of the magnitude in air above its mean.
constexpr double kEntryLevel = 6, kExitLevel = 3;
constexpr double kMaxHidden = 2;        // hidden time of a growing force, over its visible time
constexpr Eigen::Index kMinBlocks = 5;  // with fewer no part of the record counts as quiet
constexpr int kMaxRounds = 20;
constexpr double kMinDuration = 0.25;  // [s]: a shorter push is a knock, no cut

// Mean and standard deviation of the magnitude in air.
struct Air {
  double mean = 0, deviation = 0;
};

Air air_of(const Eigen::VectorXd& magnitude, Eigen::Index width,
           const std::vector<Eigen::Index>& blocks) {
  double sum = 0, squares = 0;
  for (const Eigen::Index b : blocks) sum += magnitude.segment(b * width, width).sum();
  const double count = static_cast<double>(blocks.size()) * static_cast<double>(width);
  const double mean = sum / count;
  for (const Eigen::Index b : blocks)
    squares += (magnitude.segment(b * width, width).array() - mean).square().sum();
  return {mean, std::sqrt(squares / count)};
}

// Mean and deviation in air: from the quietest tenth of the blocks, then, round by round, from all
// blocks that stay within the noise found so far.
Air quiet_level(const Eigen::VectorXd& magnitude, Eigen::Index width) {
  const Eigen::Index count = magnitude.size() / width;
  std::vector<Eigen::Index> order(count);
  for (Eigen::Index b = 0; b < count; ++b) order[b] = b;
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return magnitude.segment(a * width, width).sum() < magnitude.segment(b * width, width).sum();
  });
  std::vector<Eigen::Index> quiet(order.begin(), order.begin() + (count + 9) / 10);
  Air air = air_of(magnitude, width, quiet);
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<Eigen::Index> next;
    for (const Eigen::Index b : order)
      if (magnitude.segment(b * width, width).maxCoeff() <= air.mean + kEntryLevel * air.deviation)
        next.push_back(b);
    if (next.empty() || next == quiet) break;
    quiet = std::move(next);
    air = air_of(magnitude, width, quiet);
  }
  return air;
}

// Samples [first, last] in the material.
struct Run {
  Eigen::Index first, last;
};

// A run begins above `high` and ends when `quiet_samples` in a row lie at or below `low`.
std::vector<Run> runs_above(const Eigen::VectorXd& magnitude, double high, double low,
                            Eigen::Index quiet_samples) {
  std::vector<Run> runs;
  bool inside = false;
  for (Eigen::Index i = 0; i < magnitude.size(); ++i) {
    if (inside && i - runs.back().last > quiet_samples) inside = false;
    if (inside ? magnitude[i] > low : magnitude[i] > high) {
      if (!inside) runs.push_back({i, i});
      runs.back().last = i;
      inside = true;
    }
  }
  return runs;
}

// The instant between a sample in air and one at half the level. The noise hides the beginning of a
// force that grows evenly, for the share `hidden` of that time more.
Instant between(double in_air, double at_half, double hidden) {
  const double earliest = in_air + (in_air - at_half) * hidden;
  return {(earliest + at_half) / 2, std::abs(at_half - earliest) / 2};
}

}  // namespace

EngagementRecord find_engagement(const Eigen::VectorXd& time, const Eigen::Matrix3Xd& signal) {
  const Eigen::Index n = time.size();
  if (signal.cols() != n) throw std::invalid_argument("engagement: sizes disagree");
  EngagementRecord record;
  if (n < 2) return record;
  const double period = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  const auto width = std::max<Eigen::Index>(3, std::llround(kMinDuration / period));
  if (n / width < kMinBlocks) return record;
  const Eigen::VectorXd magnitude = signal.colwise().norm().transpose();
  const Air air = quiet_level(magnitude, width);
  const double high = air.mean + kEntryLevel * air.deviation;
  const double low = air.mean + kExitLevel * air.deviation;
  std::vector<Run> runs = runs_above(magnitude, high, low, width);
  std::erase_if(runs,
                [&](const Run& run) { return time[run.last] - time[run.first] < kMinDuration; });
  if (runs.empty()) return record;

  std::vector<double> engaged;
  for (const Run& run : runs)
    for (Eigen::Index i = run.first; i <= run.last; ++i) engaged.push_back(magnitude[i]);
  const double level = median(engaged);
  if (level < 2 * air.mean) return record;
  // Noise may lower a force of `high` to a sample within the noise of air.
  const double hidden =
      level / 2 > high ? std::min(high / (level / 2 - high), kMaxHidden) : kMaxHidden;

  Eigen::Index past = 0;  // first sample in air after the run before
  int quiet = 0;
  const auto add_air = [&](Eigen::Index from, Eigen::Index to) {
    for (Eigen::Index i = from; i < to; ++i, ++quiet) record.noise += signal.col(i).cwiseAbs2();
  };
  for (const Run& run : runs) {
    const auto strong = [&](Eigen::Index i) { return magnitude[i] >= level / 2; };
    Eigen::Index before = run.first, rise = run.first, fall = run.last;
    while (before > past && magnitude[before] > low) --before;
    while (rise < run.last && !strong(rise)) ++rise;
    while (fall > run.first && !strong(fall)) --fall;
    const Eigen::Index after = std::min(run.last + 1, n - 1);
    Engagement interval;
    if (magnitude[before] <= low) interval.entry = between(time[before], time[rise], hidden);
    if (run.last < n - 1) interval.exit = between(time[after], time[fall], hidden);
    record.intervals.push_back(interval);
    add_air(past, before);
    past = run.last + 1;
  }
  add_air(past, n);
  record.noise = (record.noise / std::max(quiet, 1)).cwiseSqrt();
  return record;
}

}  // namespace armtrue
