#include "armtrue/path/mirror.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "armtrue/path/joint_path.h"
#include "armtrue/path/low_pass.h"
#include "breaks.h"
#include "corners.h"
#include "smoothing_spline.h"

namespace armtrue {
namespace {

// Mean of the length of a vector whose square has mean 1: two normal components (Rayleigh's law).
const double kMeanOfRms = std::sqrt(std::numbers::pi) / 2;

Eigen::Index nearest_sample(const Path& path, double time, Eigen::Index from) {
  const Eigen::Index last = path.samples() - 1;
  while (from < last && path.time[from + 1] <= time) ++from;
  if (from < last && path.time[from + 1] - time < time - path.time[from]) return from + 1;
  return from;
}

// Sums what the passes say about the deviation, on one grid of program times.
class DeviationGrid {
 public:
  DeviationGrid(const Path& programmed, const std::vector<Path>& measured,
                const std::vector<Pass>& passes)
      : programmed_(programmed), tangent_(side_tangents(programmed, find_corners(programmed))) {
    double begin = programmed.time[programmed.samples() - 1], end = programmed.time[0];
    for (size_t p = 0; p < measured.size(); ++p) {
      const ClockFit& clock = passes[p].clock;
      period_ = std::max(period_, median_period(measured[p]) / (1 + clock.rate));
      begin = std::min(begin, clock.program_time(measured[p].time[0]));
      end = std::max(end, clock.program_time(measured[p].time[measured[p].samples() - 1]));
      with_force_ = with_force_ && measured[p].has_force();
    }
    begin_ = std::max(begin, programmed.time[0]);
    end = std::min(end, programmed.time[programmed.samples() - 1]);
    count_ = static_cast<Eigen::Index>((end - begin_) / period_) + 1;
    weight_ = Eigen::VectorXd::Zero(count_);
    deviation_ = Eigen::Matrix3Xd::Zero(3, count_);
    force_ = Eigen::Matrix3Xd::Zero(3, with_force_ ? count_ : 0);
  }

  // Each reading goes to the nearest place of the grid: a deviation changes little in half a period
  // and interpolation would take noise out of some samples only.
  void add(const Path& measured, const Eigen::Matrix3Xd& deviation, const ClockFit& clock) {
    for (Eigen::Index i = 0; i < measured.samples(); ++i) {
      const auto place = static_cast<Eigen::Index>(
          std::lround((clock.program_time(measured.time[i]) - begin_) / period_));
      if (place < 0 || place >= count_) continue;
      weight_[place] += 1;
      deviation_.col(place) += deviation.col(i);
      if (with_force_) force_.col(place) += measured.force.col(i);
    }
  }

  // Ends the sum.
  PathDeviation mean() {
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (weight_[i] == 0) continue;
      deviation_.col(i) /= weight_[i];
      if (with_force_) force_.col(i) /= weight_[i];
    }
    fill_gaps();
    PathDeviation result;
    result.period = period_;
    result.time = Eigen::VectorXd::LinSpaced(count_, begin_,
                                             begin_ + period_ * static_cast<double>(count_ - 1));
    result.arc_length.resize(count_);
    result.normal.resize(3, count_);
    result.along.resize(count_);
    const Eigen::VectorXd length = arc_length(programmed_);
    Eigen::Index sample = 0;
    for (Eigen::Index i = 0; i < count_; ++i) {
      sample = nearest_sample(programmed_, result.time[i], sample);
      const Eigen::Vector3d along = tangent_.col(sample);
      result.arc_length[i] = length[sample];
      result.along[i] = along.dot(deviation_.col(i));
      result.normal.col(i) = deviation_.col(i) - result.along[i] * along;
      sample = std::max<Eigen::Index>(sample - 1, 0);
    }
    result.force = std::move(force_);
    result.whole = std::move(deviation_);
    return result;
  }

 private:
  void fill_gaps() {
    Eigen::Index known = -1;
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (weight_[i] == 0) continue;
      for (Eigen::Index k = known + 1; k < i; ++k) {
        const double share =
            known < 0 ? 1 : static_cast<double>(k - known) / static_cast<double>(i - known);
        const Eigen::Index from = std::max<Eigen::Index>(known, 0);
        const auto fill = [&](Eigen::Matrix3Xd& values) {
          values.col(k) =
              share * values.col(i) + (1 - share) * (known < 0 ? Eigen::Vector3d::Zero().eval()
                                                               : Eigen::Vector3d(values.col(from)));
        };
        fill(deviation_);
        if (with_force_) fill(force_);
      }
      known = i;
    }
    for (Eigen::Index k = known + 1; k < count_; ++k) {
      deviation_.col(k) = deviation_.col(known);
      if (with_force_) force_.col(k) = force_.col(known);
    }
  }

  const Path& programmed_;
  Eigen::Matrix3Xd tangent_;
  double period_ = 0, begin_ = 0;
  bool with_force_ = true;
  Eigen::Index count_ = 0;
  Eigen::VectorXd weight_;
  Eigen::Matrix3Xd deviation_, force_;
};

// White noise per axis of samples across the path: what third differences show, since no deviation
// worth a correction changes as fast. Their median, so that jumps do not count.
double white_noise(const Eigen::Matrix3Xd& samples) {
  std::vector<double> squares;
  for (Eigen::Index i = 3; i < samples.cols(); ++i)
    squares.push_back(
        (samples.col(i) - 3 * samples.col(i - 1) + 3 * samples.col(i - 2) - samples.col(i - 3))
            .squaredNorm());
  if (squares.empty()) return 0;
  // |.|^2 of two normal components of variance 20 s^2 has the median 2 ln 2 * 20 s^2.
  return std::sqrt(median(std::move(squares)) / (40 * std::numbers::ln2));
}

using Smoother = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

Smoother smoother(const MirrorOptions& options, double cutoff, double rate) {
  if (options.points == CorrectionPoints::spline)
    return [=](const Eigen::MatrixXd& samples) { return smoothing_spline(samples, cutoff, rate); };
  return [filter = LowPass(options.order, cutoff, rate)](const Eigen::MatrixXd& samples) {
    return filter(samples);
  };
}

double noise_share(const MirrorOptions& options, double cutoff, double rate) {
  return options.points == CorrectionPoints::spline
             ? smoothing_spline_noise_share(cutoff, rate)
             : LowPass(options.order, cutoff, rate).noise_share();
}

// Below one period in the record the low pass would only draw a line through it.
void check_lowest(double cutoff, double duration) {
  if (cutoff * duration >= 1) return;
  std::array<char, 200> message{};
  std::snprintf(message.data(), message.size(),
                "a cut-off of %.4g Hz has a period of %.4g s, longer than the %.4g s of the pass: "
                "nothing of it would be left; it has to be above %.4g Hz",
                cutoff, 1 / cutoff, duration, 1 / duration);
  throw std::invalid_argument(message.data());
}

double duration(const Eigen::VectorXd& time) { return time[time.size() - 1] - time[0]; }

// Smooths every piece by itself.
Eigen::Matrix3Xd smooth(const PathDeviation& deviation, const Smoother& smoother) {
  Eigen::Matrix3Xd trend(3, deviation.normal.cols());
  Eigen::Index begin = 0;
  for (size_t piece = 0; piece <= deviation.breaks.size(); ++piece) {
    const Eigen::Index end =
        piece < deviation.breaks.size() ? deviation.breaks[piece] : deviation.normal.cols();
    trend.middleCols(begin, end - begin) =
        smoother(deviation.normal.middleCols(begin, end - begin));
    begin = end;
  }
  return trend;
}

// Mean square of what the trend misses of the true deviation, by Stein's unbiased estimate: what it
// leaves of the samples, less the noise, plus twice the noise that it kept.
double expected_square(const PathDeviation& deviation, const Eigen::Matrix3Xd& trend, double kept) {
  const auto n = static_cast<double>(trend.cols());
  const double left = (deviation.normal - trend).colwise().squaredNorm().sum() / n;
  const double noise = 2 * deviation.noise * deviation.noise;
  return std::max(left - noise + 2 * noise * kept, noise * kept);
}

// Share of the noise that piecewise smoothing keeps.
double kept_piecewise(const PathDeviation& deviation, double share) {
  return share + static_cast<double>(deviation.breaks.size() + 1) /
                     static_cast<double>(deviation.time.size());
}

// The same of polygons: each point is free in two components, and in its place if not at an end.
double kept_by_polygon(const PathDeviation& deviation, size_t points) {
  const auto all = static_cast<double>(points);
  const double inner = all - 2 * static_cast<double>(deviation.breaks.size() + 1);
  return (all + inner / 2) / static_cast<double>(deviation.time.size());
}

// Stretches of a long record that show the cut-off as well as all of it.
PathDeviation thinned(const PathDeviation& deviation) {
  constexpr Eigen::Index kRuns = 20, kRun = 2000;
  const Eigen::Index count = deviation.time.size();
  PathDeviation some;
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

// The cut-off with the least expected error.
double best_cutoff(const PathDeviation& deviation, const MirrorOptions& options, double rate) {
  constexpr Eigen::Index kLong = 100000;
  if (deviation.time.size() > kLong) return best_cutoff(thinned(deviation), options, rate);
  const double duration = deviation.time[deviation.time.size() - 1] - deviation.time[0];
  const double lowest = std::max(0.1, 2 / duration), highest = 0.25 * rate;
  double best = lowest, least = std::numeric_limits<double>::infinity();
  for (double cutoff = lowest; cutoff < highest; cutoff *= 1.25) {
    const double here =
        expected_square(deviation, smooth(deviation, smoother(options, cutoff, rate)),
                        kept_piecewise(deviation, noise_share(options, cutoff, rate)));
    if (here >= least) continue;
    least = here;
    best = cutoff;
  }
  return best;
}

// How far the values are from the straight line between two samples, and where.
std::pair<double, Eigen::Index> farthest(const Eigen::Matrix3Xd& values, Eigen::Index first,
                                         Eigen::Index last) {
  std::pair<double, Eigen::Index> most{0, first};
  for (Eigen::Index i = first + 1; i < last; ++i) {
    const double share = static_cast<double>(i - first) / static_cast<double>(last - first);
    const double off =
        (values.col(i) - (1 - share) * values.col(first) - share * values.col(last)).norm();
    if (off > most.first) most = {off, i};
  }
  return most;
}

// Samples that a polygon through some of them needs so as to stay within `tolerance` (Ramer,
// Douglas and Peucker).
void add_corners(const Eigen::Matrix3Xd& values, Eigen::Index begin, Eigen::Index end,
                 double tolerance, std::vector<Eigen::Index>& corners) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> open{{begin, end}};
  corners.push_back(begin);
  corners.push_back(end);
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const auto [off, at] = farthest(values, first, last);
    if (off <= tolerance) continue;
    corners.push_back(at);
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
}

// The points without those that the polygon through the others comes near enough to: of the
// turning points of three components many are one.
std::vector<Eigen::Index> needed(const Eigen::Matrix3Xd& values,
                                 const std::vector<Eigen::Index>& points, double tolerance) {
  std::vector<Eigen::Index> kept{points.front()};
  for (size_t k = 1; k + 1 < points.size(); ++k)
    if (farthest(values, kept.back(), points[k + 1]).first > tolerance) kept.push_back(points[k]);
  kept.push_back(points.back());
  return kept;
}

// Turning points of one component that stand out by more than `prominence`.
void add_turning_points(const Eigen::RowVectorXd& values, Eigen::Index begin, double prominence,
                        std::vector<Eigen::Index>& points) {
  Eigen::Index low = 0, high = 0;  // of the stretch since the last turning point
  int direction = 0;
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (values[i] > values[high]) high = i;
    if (values[i] < values[low]) low = i;
    if (direction >= 0 && values[high] - values[i] > prominence) {
      if (direction > 0 || high > 0) points.push_back(begin + high);
      direction = -1;
      low = i;
    } else if (direction <= 0 && values[i] - values[low] > prominence) {
      if (direction < 0 || low > 0) points.push_back(begin + low);
      direction = 1;
      high = i;
    }
    if (direction > 0) low = i;
    if (direction < 0) high = i;
  }
}

// The polygon over the points [first, last] that comes nearest to the samples: their hat functions
// make the normal equations tridiagonal.
void fit_polygon(const Eigen::Matrix3Xd& samples, const std::vector<Eigen::Index>& points,
                 Eigen::Matrix3Xd& polygon) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(count), beside = Eigen::VectorXd::Zero(count);
  Eigen::Matrix3Xd right = Eigen::Matrix3Xd::Zero(3, count);
  const auto share_of = [&](Eigen::Index k, Eigen::Index i) {  // of the next point
    const Eigen::Index from = points[static_cast<size_t>(k)];
    const Eigen::Index to = points[static_cast<size_t>(k) + 1];
    return static_cast<double>(i - from) / static_cast<double>(to - from);
  };
  const auto for_each = [&](const auto& visit) {
    Eigen::Index k = 0;
    for (Eigen::Index i = points.front(); i <= points.back(); ++i) {
      while (k + 2 < count && points[static_cast<size_t>(k) + 1] < i) ++k;
      visit(k, i, share_of(k, i));
    }
  };
  for_each([&](Eigen::Index k, Eigen::Index i, double share) {
    diagonal[k] += (1 - share) * (1 - share);
    diagonal[k + 1] += share * share;
    beside[k] += share * (1 - share);
    right.col(k) += (1 - share) * samples.col(i);
    right.col(k + 1) += share * samples.col(i);
  });
  for (Eigen::Index k = 1; k < count; ++k) {  // Thomas
    const double factor = beside[k - 1] / diagonal[k - 1];
    diagonal[k] -= factor * beside[k - 1];
    right.col(k) -= factor * right.col(k - 1);
  }
  for (Eigen::Index k = count - 1; k >= 0; --k) {
    if (k + 1 < count) right.col(k) -= beside[k] * right.col(k + 1);
    right.col(k) /= diagonal[k];
  }
  for_each([&](Eigen::Index k, Eigen::Index i, double share) {
    polygon.col(i) = (1 - share) * right.col(k) + share * right.col(k + 1);
  });
}

// Makes the trend, known to `uncertainty` per component, straight between its correction points;
// returns these. A point has to make a difference that noise would not make: 5 % of chance.
std::vector<Eigen::Index> straighten(PathDeviation& deviation, CorrectionPoints how,
                                     double uncertainty) {
  // Between two extremes, each with its noise; and of two components between a sample and the mean
  // of two others.
  const double prominence = 1.96 * std::sqrt(2.0) * uncertainty;
  const double tolerance = std::sqrt(5.99 * 1.5) * uncertainty;
  std::vector<Eigen::Index> points;
  Eigen::Index begin = 0;
  for (size_t piece = 0; piece <= deviation.breaks.size(); ++piece) {
    const Eigen::Index end =
        piece < deviation.breaks.size() ? deviation.breaks[piece] : deviation.normal.cols();
    std::vector<Eigen::Index> turning{begin, end - 1}, own;
    if (how == CorrectionPoints::turning)
      for (int axis = 0; axis < 3; ++axis)
        add_turning_points(deviation.trend.row(axis).segment(begin, end - begin), begin, prominence,
                           turning);
    std::sort(turning.begin(), turning.end());
    for (size_t k = 1; k < turning.size(); ++k)
      add_corners(deviation.trend, turning[k - 1], turning[k], tolerance, own);
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    own = needed(deviation.trend, own, tolerance);
    points.insert(points.end(), own.begin(), own.end());
    if (how == CorrectionPoints::turning) fit_polygon(deviation.normal, own, deviation.trend);
    begin = end;
  }
  return points;
}

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

int lost_samples(const Path& measured) {
  const double period = median_period(measured);
  int lost = 0;
  for (Eigen::Index i = 1; i < measured.samples(); ++i)
    lost += static_cast<int>(std::lround((measured.time[i] - measured.time[i - 1]) / period)) - 1;
  return lost;
}

double longest_gap(const Path& measured) {
  const double period = median_period(measured);
  double longest = 0;
  for (Eigen::Index i = 1; i < measured.samples(); ++i) {
    const double gap = measured.time[i] - measured.time[i - 1];
    if (gap > 1.5 * period) longest = std::max(longest, gap);
  }
  return longest;
}

// Adds bad samples of what is left of a record to those that were known, by their place in it.
void add(std::vector<BadSample>& bad, const std::vector<BadSample>& more) {
  const std::vector<BadSample> known = bad;
  size_t before = 0;  // known ones before a sample
  for (const BadSample& b : more) {
    while (before < known.size() &&
           known[before].sample <= b.sample + static_cast<Eigen::Index>(before))
      ++before;
    bad.push_back({b.sample + static_cast<Eigen::Index>(before), b.off});
  }
  std::sort(bad.begin(), bad.end(),
            [](const BadSample& a, const BadSample& b) { return a.sample < b.sample; });
}

// Registers a record and takes its bad samples out of it: first those that could mislead the clock,
// then those that only its deviations show.
Pass register_pass(const Path& programmed, Path& measured, size_t which,
                   const ClockOptions& options) {
  Pass pass;
  pass.samples = static_cast<int>(measured.samples());
  pass.lost = lost_samples(measured);
  const Path record = measured;
  const auto check_number = [&] {
    if (!too_many(pass.bad, record)) return;
    check_units(programmed, record);  // readings in another unit look bad, too
    throw TooManyBadSamples(which, pass.bad);
  };
  pass.bad = find_bad_samples(programmed, record);
  check_number();
  measured = without(record, pass.bad);
  pass.clock = fit_clock(programmed, measured, options);
  Path deviation = registered(measured, pass.clock);
  const Eigen::Matrix3Xd wanted = position_at(programmed, deviation.time);
  deviation.position -= wanted;
  add(pass.bad, find_bad_deviations(deviation, wanted));
  check_number();
  measured = without(record, pass.bad);
  pass.longest_gap = longest_gap(measured);
  return pass;
}

bool engaged(const EngagementRecord& record, double time) {
  return std::any_of(record.intervals.begin(), record.intervals.end(), [&](const Engagement& e) {
    return (!e.entry || e.entry->time <= time) && (!e.exit || time <= e.exit->time);
  });
}

// Measured minus programmed, each sample at its own time.
Eigen::Matrix3Xd deviations(const Path& programmed, const Path& measured, const ClockFit& clock) {
  Path own = registered(measured, clock);
  own.position -= position_at(programmed, own.time);
  return std::move(own.position);
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

// Of the passes [first, last).
PathDeviation mean_deviation(const Path& programmed, const std::vector<Path>& measured,
                             const std::vector<Pass>& passes, size_t first, size_t last) {
  DeviationGrid grid(programmed, measured, passes);
  for (size_t p = first; p < last; ++p)
    grid.add(measured[p], deviations(programmed, measured[p], passes[p].clock), passes[p].clock);
  return grid.mean();
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
  for (size_t p = 0; p < measured.size(); ++p)
    result.passes.push_back(register_pass(executed, measured[p], p, options.clock));

  PathDeviation& deviation = result.deviation;
  deviation = mean_deviation(programmed, measured, result.passes, 0, measured.size());
  const double halfway = 0.5 * (deviation.time[0] + deviation.time[deviation.time.size() - 1]);
  for (const Pass& pass : result.passes)
    deviation.clock_covariance +=
        pass.clock.covariance_at(halfway) / std::pow(static_cast<double>(result.passes.size()), 2);
  std::vector<Eigen::Matrix3Xd> single;
  for (size_t p = 0; measured.size() > 1 && p < measured.size(); ++p)
    single.push_back(mean_deviation(programmed, measured, result.passes, p, p + 1).normal);
  deviation.noise = white_noise(deviation.normal);
  const double rate = 1 / deviation.period;
  const auto window = static_cast<Eigen::Index>(std::ceil(0.32 * rate));
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

  if (options.cutoff) check_lowest(*options.cutoff, duration(deviation.time));
  result.cutoff = options.cutoff ? *options.cutoff : best_cutoff(deviation, options, rate);
  const double share = noise_share(options, result.cutoff, rate);
  deviation.trend = smooth(deviation, smoother(options, result.cutoff, rate));
  const std::vector<Eigen::Index> points =
      straighten(deviation, options.points, deviation.noise * std::sqrt(share));

  const double kept = options.points == CorrectionPoints::turning
                          ? kept_by_polygon(deviation, points.size())
                          : kept_piecewise(deviation, share);
  double missed = expected_square(deviation, deviation.trend, kept);
  if (!single.empty()) {
    // What differs from pass to pass, slower than the noise, comes back in the next one.
    const Smoother low_pass = smoother(options, result.cutoff, rate);
    double square = 0;
    for (const Eigen::Matrix3Xd& pass : single) {
      PathDeviation other = deviation;
      other.normal = pass - deviation.normal;
      square += smooth(other, low_pass).colwise().squaredNorm().mean();
    }
    const auto passes = static_cast<double>(single.size());
    const double noise = 2 * deviation.noise * deviation.noise * passes * share;
    const double spread = std::max(0.0, square / (passes - 1) - noise);
    deviation.spread = std::sqrt(spread / 2);
    missed += spread * (1 + 1 / passes);
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
  if (options.engaged_only && deviation.engagement.intervals.empty())
    throw std::invalid_argument(
        "the record does not show when the tool cuts (it never does, always does, or has no "
        "force): record from air to air with fx_n, fy_n and fz_n, or leave out --engaged-only");
  if (options.engaged_only)
    for (Eigen::Index i = 0; i < programmed.samples(); ++i)
      if (!engaged(deviation.engagement, programmed.time[i])) result.correction.col(i).setZero();
  join_sides(programmed, corners, result.correction);
  result.clipped = clip(result.correction, options.max);
  // Beyond the record nothing is known: the path stays what was run. Standing beside the record is
  // standing at its end.
  const Eigen::Index samples = programmed.samples();
  const double begins = deviation.time[0] - deviation.period;
  const double ends = deviation.time[deviation.time.size() - 1] + deviation.period;
  Eigen::Index first = 0, last = samples - 1;
  while (first < last && programmed.time[first] < begins) ++first;
  while (first < last && programmed.time[last] > ends) --last;
  while (first > 0 && moves[first - 1] == 0) --first;
  while (last + 1 < samples && moves[last + 1] == 0) ++last;
  result.correction.leftCols(first) = run.leftCols(first);
  result.correction.rightCols(samples - 1 - last) = run.rightCols(samples - 1 - last);
  result.unrecorded =
      static_cast<int>(moves.head(first).sum() + moves.tail(samples - 1 - last).sum());
  result.position = programmed.position + result.correction;
  // What was not taken off stays: by the gain, by --max, outside the material.
  const double stays =
      lengths_in_motion(across(programmed, corners, trend + result.correction - run), moves).mean;
  result.expected_after = std::sqrt(stays * stays + std::pow(kMeanOfRms * result.gain, 2) * missed);
  Eigen::Index sample = 0;
  for (const Eigen::Index point : points) {
    sample = nearest_sample(programmed, deviation.time[point], sample);
    if (result.points.empty() || result.points.back() != sample) result.points.push_back(sample);
  }
  return result;
}

Eigen::Matrix3Xd correct_from_force(const Path& programmed, const Eigen::Matrix3Xd& deviation,
                                    const MirrorOptions& options) {
  const double cutoff = options.cutoff.value_or(kPaperCutoff);
  check_lowest(cutoff, duration(programmed.time));
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
