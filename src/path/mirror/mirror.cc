#include "armtrue/path/mirror/mirror.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/low_pass.h"
#include "armtrue/statistics/intervals.h"
#include "path/mirror/breaks.h"
#include "path/mirror/corners.h"
#include "path/mirror/frame_error.h"
#include "path/mirror/mean_deviation.h"
#include "path/mirror/straightening.h"
#include "path/mirror/trend.h"
#include "statistics/white_noise.h"

namespace armtrue {
namespace {

// Mean length over RMS length of a vector with two normal components (Rayleigh distribution).
const double kMeanOfRms = std::sqrt(std::numbers::pi) / 2;

// Shortens the vectors that are longer than `max`; returns their number.
int clip(Eigen::Matrix3Xd& vectors, double max) {
  int clipped = 0;
  for (auto vector : vectors.colwise()) {
    const double length = vector.norm();
    if (length <= max) continue;
    vector *= max / length;
    ++clipped;
  }
  return clipped;
}

// The trend at the samples of the program. It jumps half a period before the first sample of a
// piece, or, if a corner is near, at the corner.
Eigen::Matrix3Xd trend_on(const Path& programmed, const std::vector<Corner>& corners,
                          const PathDeviation& deviation) {
  constexpr double kMaxDistance = 2;  // of a corner, in periods
  std::vector<double> jumps;
  for (const Eigen::Index b : deviation.breaks) {
    jumps.push_back(deviation.time[b] - deviation.period / 2);
    for (const Corner& corner : corners) {
      const double time = programmed.time[corner.last + 1];
      if (std::abs(time - jumps.back()) < kMaxDistance * deviation.period) jumps.back() = time;
    }
  }
  Eigen::Matrix3Xd trend(3, programmed.samples());
  size_t piece = 0;
  for (Eigen::Index i = 0; i < programmed.samples(); ++i) {
    const double time = programmed.time[i];
    while (piece < jumps.size() && time >= jumps[piece]) ++piece;
    const Eigen::Index first = piece > 0 ? deviation.breaks[piece - 1] : 0;
    const Eigen::Index last =
        (piece < jumps.size() ? deviation.breaks[piece] : deviation.time.size()) - 1;
    const double place = std::clamp((time - deviation.time[0]) / deviation.period,
                                    static_cast<double>(first), static_cast<double>(last));
    const double before = std::floor(place);
    const auto k = static_cast<Eigen::Index>(before);
    const double share = place - before;
    trend.col(i) =
        (1 - share) * deviation.trend.col(k) + share * deviation.trend.col(std::min(k + 1, last));
  }
  return without_along(programmed, corners, std::move(trend));
}

// 1 for each sample at which the tool moves, 0 at standstill.
Eigen::VectorXd moving(const Path& programmed) {
  Eigen::VectorXd moves = Eigen::VectorXd::Zero(programmed.samples());
  for (Eigen::Index i = 1; i + 1 < programmed.samples(); ++i)
    moves[i] = programmed.position.col(i + 1) != programmed.position.col(i - 1);
  return moves;
}

ErrorSummary lengths_in_motion(const Eigen::Matrix3Xd& vectors, const Eigen::VectorXd& moves) {
  std::vector<double> lengths;
  for (Eigen::Index i = 0; i < vectors.cols(); ++i)
    if (moves[i] != 0) lengths.push_back(vectors.col(i).norm());
  return summarize(std::move(lengths));
}

// Mean square of the difference of a pass from the mean of the passes, without its noise.
struct PassToPass {
  double square = 0;  // smoothed
  double whole =
      0;  // with what changes faster than the smoothed one, if it stands out of the noise
  std::array<double, 2> ci95{0, 0};
};

PassToPass pass_to_pass(const Path& programmed, const std::vector<Path>& measured,
                           const std::vector<Pass>& passes, const PathDeviation& mean,
                           const Smoother& low_pass) {
  double square = 0, whole = 0;
  for (size_t p = 0; p < measured.size(); ++p) {
    const Eigen::Matrix3Xd own =
        deviation_of_pass(programmed, measured, passes, p).normal - mean.normal;
    square += smooth(own, mean.breaks, low_pass).colwise().squaredNorm().mean();
    whole += own.colwise().squaredNorm().mean();
  }
  const auto count = static_cast<double>(measured.size());
  const double noise = 2 * mean.noise * mean.noise * count * low_pass.noise_share;
  const double value = square / (count - 1) - noise;
  // The smoothed noise has as many free components; that of a sample is known to kNoiseVariance / n.
  constexpr double kNoiseVariance = 3.8;  // of the median of third differences, by simulation
  const auto samples = static_cast<double>(mean.time.size());
  const double freedom = 2 * (count - 1) * samples * low_pass.noise_share;
  const auto deviation = [&](double truth) {
    return std::sqrt((4 * truth + 2 * noise) * noise / freedom +
                     noise * noise * kNoiseVariance / samples);
  };
  const double of_samples = noise / low_pass.noise_share;
  const double with_fast = whole / (count - 1) - of_samples;
  const bool stands_out = with_fast - value > 2 * of_samples * std::sqrt(kNoiseVariance / samples);
  return {std::max(0.0, value), std::max(0.0, stands_out ? with_fast : value),
          not_negative_ci95(value, deviation)};
}

// MirrorResult::expected_after. What stays of the trend holds what the passes have for themselves
// and left in their mean.
double expected_distance(double stays, const MirrorResult& result, double missed, double between) {
  const auto passes = static_cast<double>(result.passes.size());
  const double of_mean = std::pow(1 - result.gain, 2) * between / passes;
  const double square = kMeanOfRms * kMeanOfRms;
  return std::sqrt(std::max(0.0, stays * stays - square * of_mean) +
                   square *
                       (std::pow(result.gain, 2) * missed + between + result.frame.mean_square));
}

// Samples of the program that follow each other.
struct Part {
  Eigen::Index first = 0, last = 0;
};

// What lies from one time to another; the first one behind the last one if nothing does.
Part between(const Path& programmed, double begins, double ends) {
  Part samples{0, programmed.samples() - 1};
  auto& [first, last] = samples;
  while (first <= last && programmed.time[first] < begins) ++first;
  while (first <= last && programmed.time[last] > ends) --last;
  return samples;
}

// What the record shows. A standstill beside the record belongs to it.
Part recorded(const Path& programmed, const Eigen::VectorXd& moves,
              const PathDeviation& deviation) {
  const double begins = deviation.time[0] - deviation.period;
  const double ends = deviation.time[deviation.time.size() - 1] + deviation.period;
  Part samples = between(programmed, begins, ends);
  auto& [first, last] = samples;
  while (first > 0 && moves[first - 1] == 0) --first;
  while (last + 1 < programmed.samples() && moves[last + 1] == 0) ++last;
  return samples;
}

// The share of a correction at each sample: 0 outside a part of the program; from an end of the
// part that the tool passes in motion, it grows to 1 in proportion to the time in motion, within
// `length` [s].
Eigen::VectorXd share_of_part(const Path& programmed, const Eigen::VectorXd& moves,
                              const Part& samples, double length) {
  const Eigen::Index count = programmed.samples();
  Eigen::VectorXd share = Eigen::VectorXd::Ones(count);
  share.head(samples.first).setZero();
  share.tail(count - 1 - samples.last).setZero();
  const auto step = [&](Eigen::Index later) {
    return moves[later] * (programmed.time[later] - programmed.time[later - 1]);
  };
  double moved = 0;
  for (Eigen::Index i = samples.first; i > 0 && i <= samples.last; ++i)
    share[i] *= std::min(1.0, (moved += step(i)) / length);
  moved = 0;
  for (Eigen::Index i = samples.last; i + 1 < count && i >= samples.first; --i)
    share[i] *= std::min(1.0, (moved += step(i + 1)) / length);
  return share;
}

// The same where the tool is in the material.
Eigen::VectorXd share_engaged(const Path& programmed, const Eigen::VectorXd& moves,
                              const EngagementRecord& record, double length) {
  if (record.intervals.empty())
    throw std::invalid_argument(
        "the record does not show when the tool cuts (it never does, always does, or has no "
        "force): record from air to air with fx_n, fy_n and fz_n, or leave out --engaged-only");
  constexpr double kEver = std::numeric_limits<double>::infinity();
  Eigen::VectorXd share = Eigen::VectorXd::Zero(programmed.samples());
  for (const auto& [entry, exit] : record.intervals) {
    const Part samples =
        between(programmed, entry ? entry->time : -kEver, exit ? exit->time : kEver);
    if (samples.first <= samples.last)
      share = share.cwiseMax(share_of_part(programmed, moves, samples, length));
  }
  return share;
}

// The samples of the program nearest in time to points of the deviation.
std::vector<Eigen::Index> samples_at(const Path& programmed, const PathDeviation& deviation,
                                     const std::vector<Eigen::Index>& points) {
  std::vector<Eigen::Index> samples;
  Eigen::Index sample = 0;
  for (const Eigen::Index point : points) {
    sample = nearest_sample(programmed, deviation.time[point], sample);
    if (samples.empty() || samples.back() != sample) samples.push_back(sample);
  }
  return samples;
}

// The trend and the path that ran on the samples of the program.
struct OnProgram {
  const std::vector<Corner>& corners;
  Eigen::VectorXd moves;        // see moving()
  Eigen::Matrix3Xd trend, run;  // from the programmed path
};

// Fills in the correction, whose gain is known, with what of it was clipped or lies beside the
// record.
void correct_with(const OnProgram& on, const Path& programmed, const MirrorOptions& options,
                  MirrorResult& result) {
  result.correction = without_along(programmed, on.corners, on.run - result.gain * on.trend);
  const double growth = 1 / result.cutoff;
  if (options.engaged_only)
    result.correction *=
        share_engaged(programmed, on.moves, result.deviation.engagement, growth).asDiagonal();
  join_sides(programmed, on.corners, result.correction);
  result.clipped = clip(result.correction, options.max);
  const Part samples = recorded(programmed, on.moves, result.deviation);
  const Eigen::VectorXd share = share_of_part(programmed, on.moves, samples, growth);
  result.correction = on.run + (result.correction - on.run) * share.asDiagonal();
  result.unrecorded =
      static_cast<int>(on.moves.head(samples.first).sum() +
                       on.moves.tail(programmed.samples() - 1 - samples.last).sum());
  result.position = programmed.position + result.correction;
}

}  // namespace

MirrorResult mirror_correct(const Path& programmed, const std::vector<Path>& records,
                            const MirrorOptions& options) {
  if (records.empty()) throw std::invalid_argument("there is no measured pass");
  Path previous;
  if (options.executed) {
    previous.time = programmed.time;
    previous.position = *options.executed;
  }
  const Path& executed = options.executed ? previous : programmed;
  MirrorResult result;
  std::vector<Path> measured = records;
  result.passes = register_passes(executed, measured, options.clock);
  PathDeviation& deviation = result.deviation;
  deviation = mean_deviation(programmed, measured, result.passes);
  deviation.noise = white_noise(deviation.normal);
  find_breaks(programmed, deviation);
  result.frame = frame_error(programmed, deviation, result.passes.front().clock);

  result.cutoff = choose_cutoff(deviation, options);
  const Smoother low_pass = smoother(options, result.cutoff, 1 / deviation.period);
  deviation.trend = smooth(deviation.normal, deviation.breaks, low_pass);
  const std::vector<Eigen::Index> points =
      straighten(deviation, options.points, deviation.noise * std::sqrt(low_pass.noise_share));
  double missed = expected_square(deviation, options.points, points.size(), low_pass.noise_share);
  double between = 0;  // mean square of what a pass has for itself; no correction takes it off
  if (measured.size() > 1) {
    const PassToPass differ =
        pass_to_pass(programmed, measured, result.passes, deviation, low_pass);
    deviation.spread = std::sqrt(differ.square / 2);
    for (size_t k = 0; k < 2; ++k) deviation.spread_ci95[k] = std::sqrt(differ.ci95[k] / 2);
    between = differ.whole;
    missed += differ.square / static_cast<double>(measured.size());
  }

  const std::vector<Corner> corners = find_corners(programmed);
  const OnProgram on{corners, moving(programmed), trend_on(programmed, corners, deviation),
                     executed.position - programmed.position};
  result.before = lengths_in_motion(on.trend, on.moves);
  const double power = result.before.rms * result.before.rms;
  result.gain = options.gain ? *options.gain
                : power > 0  ? std::max(0.0, 1 - std::min(missed, power) / power)
                             : 0;
  if (options.executed) result.uncorrected = lengths_in_motion(on.trend - on.run, on.moves).mean;
  correct_with(on, programmed, options, result);
  result.points = samples_at(programmed, deviation, points);
  // The uncorrected part of the trend, because of the gain, the largest correction, or outside the
  // material.
  const double stays =
      lengths_in_motion(without_along(programmed, corners, on.trend + result.correction - on.run),
                        on.moves)
          .mean;
  result.expected_after = expected_distance(stays, result, missed, between);
  return result;
}

Eigen::Matrix3Xd correct_from_force(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const MirrorOptions& options) {
  const double cutoff = options.cutoff.value_or(kPaperCutoff);
  check_lowest(cutoff, programmed.time);
  const LowPass filter(options.order, cutoff, 1 / median_period(programmed));
  const std::vector<Corner> corners = find_corners(programmed);
  Eigen::Matrix3Xd correction =
      -options.gain.value_or(1) * without_along(programmed, corners, filter(deviation));
  join_sides(programmed, corners, correction);
  clip(correction, options.max);
  return programmed.position + correction;
}

}  // namespace armtrue
