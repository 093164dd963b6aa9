#include "armtrue/path/mirror/mirror.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/joint_path.h"
#include "armtrue/path/low_pass.h"
#include "path/mirror/breaks.h"
#include "path/mirror/corners.h"
#include "path/mirror/mean_deviation.h"
#include "path/mirror/straightening.h"
#include "path/mirror/trend.h"
#include "statistics/white_noise.h"

namespace armtrue {
namespace {

// Mean of the length of a vector whose square has mean 1: two normal components (Rayleigh's law).
const double kMeanOfRms = std::sqrt(std::numbers::pi) / 2;
constexpr double kJumpWindow = 0.32;  // [s], ten samples of 32 ms: noise falls to a third

// Vectors without their part along the path.
Eigen::Matrix3Xd across(const Path& path, const std::vector<Corner>& corners,
                        Eigen::Matrix3Xd vectors) {
  const Eigen::Matrix3Xd tangent = side_tangents(path, corners);
  for (Eigen::Index i = 0; i < vectors.cols(); ++i)
    vectors.col(i) -= tangent.col(i).dot(vectors.col(i)) * tangent.col(i);
  return vectors;
}

// Shortens what is longer than `max`; returns how many were.
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

// The trend at the samples of the program. It jumps half a period before the first sample after a
// break, or, if that is a corner, at this.
Eigen::Matrix3Xd trend_on(const Path& programmed, const std::vector<Corner>& corners,
                          const PathDeviation& deviation) {
  constexpr double kNear = 2;  // periods
  std::vector<double> jumps;
  for (const Eigen::Index b : deviation.breaks) {
    jumps.push_back(deviation.time[b] - deviation.period / 2);
    for (const Corner& corner : corners) {
      const double time = programmed.time[corner.last + 1];
      if (std::abs(time - jumps.back()) < kNear * deviation.period) jumps.back() = time;
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
    const auto k = static_cast<Eigen::Index>(place);
    const double share = place - static_cast<double>(k);
    trend.col(i) =
        (1 - share) * deviation.trend.col(k) + share * deviation.trend.col(std::min(k + 1, last));
  }
  return across(programmed, corners, std::move(trend));
}

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

bool engaged(const EngagementRecord& record, double time) {
  return std::any_of(record.intervals.begin(), record.intervals.end(), [&](const Engagement& e) {
    return (!e.entry || e.entry->time <= time) && (!e.exit || time <= e.exit->time);
  });
}

// Without a force a step of the deviation shows the cut, but a corner or a reversal makes one too.
void drop_other_causes(const std::vector<double>& breaks, PathDeviation& deviation) {
  const auto at_break = [&](const std::optional<Instant>& instant) {
    return instant && std::any_of(breaks.begin(), breaks.end(), [&](double time) {
             return std::abs(time - instant->time) <= instant->uncertainty + deviation.period;
           });
  };
  std::erase_if(deviation.engagement.intervals,
                [&](const Engagement& e) { return at_break(e.entry) || at_break(e.exit); });
}

// When the tool cuts, and where the deviation jumps: where the program starts, stops or turns, or
// where the tool enters or leaves the material.
void find_breaks(const Path& programmed, PathDeviation& deviation) {
  const double rate = 1 / deviation.period;
  const auto window = static_cast<Eigen::Index>(std::ceil(kJumpWindow * rate));
  deviation.engagement = find_engagement(
      deviation.time, deviation.force.cols() > 0 ? deviation.force : deviation.normal);
  std::vector<double> times = program_breaks(programmed);
  if (deviation.force.cols() == 0) drop_other_causes(times, deviation);
  for (const Engagement& engagement : deviation.engagement.intervals)
    for (const auto& instant : {engagement.entry, engagement.exit})
      if (instant) times.push_back(instant->time);
  std::vector<Eigen::Index> likely;
  for (const double time : times) likely.push_back(std::lround((time - deviation.time[0]) * rate));
  deviation.breaks = find_jumps(deviation.normal, deviation.noise, window, likely);
}

// Mean square by which passes differ from their mean, slower than the noise.
double pass_to_pass_square(const Path& programmed, const std::vector<Path>& measured,
                           const std::vector<Pass>& passes, const PathDeviation& mean,
                           const Smoother& low_pass) {
  double square = 0;
  for (size_t p = 0; p < measured.size(); ++p) {
    const Eigen::Matrix3Xd own =
        deviation_of_pass(programmed, measured, passes, p).normal - mean.normal;
    square += smooth(own, mean.breaks, low_pass).colwise().squaredNorm().mean();
  }
  const auto count = static_cast<double>(measured.size());
  const double noise = 2 * mean.noise * mean.noise * count * low_pass.noise_share;
  return std::max(0.0, square / (count - 1) - noise);
}

// Leaves the correction only where the tool cuts.
void keep_engaged(const Path& programmed, const EngagementRecord& record,
                  Eigen::Matrix3Xd& correction) {
  if (record.intervals.empty())
    throw std::invalid_argument(
        "the record does not show when the tool cuts (it never does, always does, or has no "
        "force): record from air to air with fx_n, fy_n and fz_n, or leave out --engaged-only");
  for (Eigen::Index i = 0; i < programmed.samples(); ++i)
    if (!engaged(record, programmed.time[i])) correction.col(i).setZero();
}

// Beyond the record nothing is known: the path stays what was run. Standing beside the record is
// standing at its end. Returns the number of samples in motion there.
int keep_unrecorded(const Path& programmed, const Path& executed, const Eigen::VectorXd& moves,
                    const PathDeviation& deviation, Eigen::Matrix3Xd& correction) {
  const Eigen::Index samples = programmed.samples();
  const double begins = deviation.time[0] - deviation.period;
  const double ends = deviation.time[deviation.time.size() - 1] + deviation.period;
  Eigen::Index first = 0, last = samples - 1;
  while (first < last && programmed.time[first] < begins) ++first;
  while (first < last && programmed.time[last] > ends) --last;
  while (first > 0 && moves[first - 1] == 0) --first;
  while (last + 1 < samples && moves[last + 1] == 0) ++last;
  const Eigen::Index after = samples - 1 - last;
  correction.leftCols(first) =
      executed.position.leftCols(first) - programmed.position.leftCols(first);
  correction.rightCols(after) =
      executed.position.rightCols(after) - programmed.position.rightCols(after);
  return static_cast<int>(moves.head(first).sum() + moves.tail(after).sum());
}

// The samples of the program that lie nearest to those points of the deviation.
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

  result.cutoff = choose_cutoff(deviation, options);
  const Smoother low_pass = smoother(options, result.cutoff, 1 / deviation.period);
  deviation.trend = smooth(deviation.normal, deviation.breaks, low_pass);
  const std::vector<Eigen::Index> points =
      straighten(deviation, options.points, deviation.noise * std::sqrt(low_pass.noise_share));
  double missed = expected_square(deviation, options.points, points.size(), low_pass.noise_share);
  if (measured.size() > 1) {
    const double square =
        pass_to_pass_square(programmed, measured, result.passes, deviation, low_pass);
    deviation.spread = std::sqrt(square / 2);
    missed += square * (1 + 1 / static_cast<double>(measured.size()));  // in the next pass
  }

  const std::vector<Corner> corners = find_corners(programmed);
  const Eigen::Matrix3Xd trend = trend_on(programmed, corners, deviation);
  const Eigen::VectorXd moves = moving(programmed);
  result.before = lengths_in_motion(trend, moves);
  const double power = result.before.rms * result.before.rms;
  result.gain = options.gain ? *options.gain
                : power > 0  ? std::max(0.0, 1 - std::min(missed, power) / power)
                             : 0;
  const auto run = executed.position - programmed.position;
  result.correction = across(programmed, corners, run - result.gain * trend);
  if (options.executed) result.uncorrected = lengths_in_motion(trend - run, moves).mean;
  if (options.engaged_only) keep_engaged(programmed, deviation.engagement, result.correction);
  join_sides(programmed, corners, result.correction);
  result.clipped = clip(result.correction, options.max);
  result.unrecorded = keep_unrecorded(programmed, executed, moves, deviation, result.correction);
  result.position = programmed.position + result.correction;
  result.points = samples_at(programmed, deviation, points);
  // What was not taken off stays: by the gain, by --max, outside the material.
  const double stays =
      lengths_in_motion(across(programmed, corners, trend + result.correction - run), moves).mean;
  result.expected_after = std::sqrt(stays * stays + std::pow(kMeanOfRms * result.gain, 2) * missed);
  return result;
}

Eigen::Matrix3Xd correct_from_force(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const MirrorOptions& options) {
  const double cutoff = options.cutoff.value_or(kPaperCutoff);
  check_lowest(cutoff, programmed.time);
  const LowPass filter(options.order, cutoff, 1 / median_period(programmed));
  const std::vector<Corner> corners = find_corners(programmed);
  Eigen::Matrix3Xd correction =
      -options.gain.value_or(1) * across(programmed, corners, filter(deviation));
  join_sides(programmed, corners, correction);
  clip(correction, options.max);
  return programmed.position + correction;
}

std::optional<ForceLine> measured_on_predicted(const PathDeviation& deviation,
                                               const Path& programmed, const Robot& robot) {
  if (deviation.force.cols() == 0) return std::nullopt;
  const Eigen::Matrix3Xd force = interpolate(deviation.time, deviation.force, programmed.time);
  const Eigen::Matrix3Xd predicted =
      across(programmed, find_corners(programmed),
             deviation_from_force(RobotModel(robot), joint_path(programmed, robot.chain), force));
  return line_through_origin(interpolate(programmed.time, predicted, deviation.time),
                             deviation.normal);
}

std::optional<ForceLaw> force_law(const PathDeviation& deviation, const Path& programmed,
                                  const Eigen::MatrixXd& axes, const LowPass& filter) {
  if (deviation.force.cols() == 0) return std::nullopt;
  const Eigen::Matrix3Xd wanted = position_at(programmed, deviation.time);
  std::vector<Eigen::Index> moves;
  for (Eigen::Index i = 1; i + 1 < wanted.cols(); ++i)
    if ((wanted.col(i + 1) - wanted.col(i - 1)).norm() > kStandstill) moves.push_back(i);
  const auto moving = [&](const Eigen::MatrixXd& samples) -> Eigen::MatrixXd {
    return filter(samples)(Eigen::all, moves);
  };
  ForceRecord record;
  record.deviation = moving(deviation.whole);
  record.force = moving(deviation.force);
  record.force_noise = deviation.engagement.noise * std::sqrt(filter.noise_share());
  record.direction = moving(motion_directions(axes));
  for (const Eigen::Matrix3Xd& error :
       clock_errors(programmed, deviation.time, deviation.clock_covariance))
    record.shared_errors.push_back(moving(error));
  return force_law(record);
}

Path registered(const Path& measured, const ClockFit& clock) {
  Path path = measured;
  path.time = (measured.time.array() - clock.offset) / (1 + clock.rate);
  path.position = (clock.program_from_instrument.rotation * measured.position).colwise() +
                  clock.program_from_instrument.translation;
  return path;
}

}  // namespace armtrue
