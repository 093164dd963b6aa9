#include "path/samples/departures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "armtrue/statistics/summary.h"
#include "path/samples/plausible_motion.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kQuick = 0.25;  // [s]: an arm takes longer to go out and come back
constexpr size_t kMaxSide = 6;   // samples on either side that say where the tool was

// A sample against a prediction from others: how far off, and by how many times the noise of one
// sample that may differ by chance.
struct Difference {
  Vector3d vector;
  double deviation;
  double off() const { return vector.norm(); }
};

// From the straight line through the first `count` of the others.
Difference from_line(double time, const Vector3d& sample, const double* times,
                     const Vector3d* others, size_t count) {
  const auto n = static_cast<double>(count);
  double mean = 0, square = 0;
  for (size_t j = 0; j < count; ++j) mean += times[j] / n;
  for (size_t j = 0; j < count; ++j) square += (times[j] - mean) * (times[j] - mean);
  Vector3d off = sample;
  for (size_t j = 0; j < count; ++j)
    off -= (1 / n + (time - mean) * (times[j] - mean) / square) * others[j];
  return {off, std::sqrt(1 + 1 / n + (time - mean) * (time - mean) / square)};
}

// From the cubic through four others: evenly accelerated motion does not differ from it.
Difference from_cubic(double time, const Vector3d& sample, const std::array<double, 4>& times,
                      const std::array<Vector3d, 4>& others) {
  Vector3d off = sample;
  double variance = 1;
  for (size_t j = 0; j < 4; ++j) {
    double weight = 1;
    for (size_t k = 0; k < 4; ++k)
      if (k != j) weight *= (time - times[k]) / (times[j] - times[k]);
    off -= weight * others[j];
    variance += weight * weight;
  }
  return {off, std::sqrt(variance)};
}

// The samples on either side of a run, the nearest first, and its own first and last.
struct Surroundings {
  size_t count;  // on either side
  std::array<double, kMaxSide> before, after;
  std::array<Vector3d, kMaxSide> before_at, after_at;
  std::array<double, 2> ends;
  std::array<Vector3d, 2> ends_at;

  Difference both(size_t end) const {
    return from_cubic(ends[end], ends_at[end], {before[1], before[0], after[0], after[1]},
                      {before_at[1], before_at[0], after_at[0], after_at[1]});
  }
  std::array<Difference, 2> sides(size_t end) const {
    return {from_line(ends[end], ends_at[end], before.data(), before_at.data(), count),
            from_line(ends[end], ends_at[end], after.data(), after_at.data(), count)};
  }
};

// How far something departs by itself: from what both sides show, and from the nearer of the sides.
struct Motion {
  double both = 0, side = 0;
};

constexpr size_t kSideOfMotion = 3;  // with more, every start and stop would be a departure

// The most that the program departs so, about some times, increasing, of its own.
Motion departures(const Path& programmed, const Eigen::ArrayXd& times, double period, Index run) {
  constexpr auto kSide = static_cast<Index>(kSideOfMotion);
  std::vector<Eigen::Matrix3Xd> at;  // of samples 0 .. 2 kSide + run - 1 about each time
  const double middle = 0.5 * static_cast<double>(2 * kSide + run - 1);
  for (Index k = 0; k < 2 * kSide + run; ++k)
    at.push_back(position_at(programmed, times + (static_cast<double>(k) - middle) * period));
  Surroundings around{};
  around.count = kSideOfMotion;
  around.ends = {0, static_cast<double>(run - 1)};
  for (size_t k = 0; k < kSideOfMotion; ++k) {
    around.before[k] = -1 - static_cast<double>(k);
    around.after[k] = static_cast<double>(run) + static_cast<double>(k);
  }
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Motion most;
  for (Index i = 0; i < times.size(); ++i) {
    const auto sample = [&](Index k) -> Vector3d { return at[static_cast<size_t>(k)].col(i); };
    for (Index k = 0; k < kSide; ++k) {
      around.before_at[static_cast<size_t>(k)] = sample(kSide - 1 - k);
      around.after_at[static_cast<size_t>(k)] = sample(kSide + run + k);
    }
    around.ends_at = {sample(kSide), sample(kSide + run - 1)};
    Motion here{kNone, kNone};
    for (const size_t end : {size_t{0}, size_t{1}}) {
      const auto [before, after] = around.sides(end);
      here.side = std::min({here.side, before.off(), after.off()});
      here.both = std::min(here.both, around.both(end).off());
    }
    most.both = std::max(most.both, std::min(here.both, here.side));
    most.side = std::max(most.side, here.side);
  }
  return most;
}

// How far the program goes out and back in as short a time: about each of its samples, and half a
// period before and after. A long one in parts, for the memory.
Motion departures(const Path& programmed, double period, Index run) {
  constexpr Index kPart = 8192;
  Motion most;
  for (Index begin = 0; begin < programmed.samples(); begin += kPart) {
    const auto times =
        programmed.time.segment(begin, std::min(kPart, programmed.samples() - begin)).array();
    for (const double shift : {-0.5, 0.0, 0.5}) {
      const Motion here = departures(programmed, times + shift * period, period, run);
      most = {std::max(most.both, here.both), std::max(most.side, here.side)};
    }
  }
  return most;
}

class DepartureFilter {
 public:
  DepartureFilter(const Path& programmed, const Path& measured, double speed, double rounding,
                  std::vector<Index> good)
      : programmed_(programmed),
        path_(measured),
        period_(median_period(measured)),
        speed_(speed),
        side_(kSideOfMotion),
        good_(std::move(good)),
        rounding_(rounding) {}

  DepartureFilter(const Path& deviation, const Eigen::Matrix3Xd& wanted, double rounding,
                  std::vector<Index> good)
      : programmed_(deviation),
        path_(deviation),
        wanted_(&wanted),
        period_(median_period(deviation)),
        side_(kMaxSide),
        good_(std::move(good)),
        rounding_(rounding) {}

  std::vector<Index> good_samples() {
    while (size() > 4 * side() && !crowded()) {
      find_noise();
      const std::vector<Run> runs = departures();
      if (!remove(runs)) break;
    }
    return good_;
  }

  double tolerance() const { return std::max(kFreePlay, threshold_ * std::sqrt(1.5) * usual_); }

 private:
  struct Run {
    Index first, length;  // among the good samples
    double excess;        // off over what is allowed
  };

  Index size() const { return static_cast<Index>(good_.size()); }
  Index side() const { return static_cast<Index>(side_); }
  bool crowded() const {
    return static_cast<double>(path_.samples() - size()) >
           kShareTooMany * static_cast<double>(path_.samples());
  }
  double time(Index k) const { return path_.time[good_[static_cast<size_t>(k)]]; }
  Vector3d at(Index k) const { return path_.position.col(good_[static_cast<size_t>(k)]); }

  Index longest_run() const {
    return std::min(kFew, static_cast<Index>(std::floor(kQuick / period_)) - 1);
  }

  // The samples on either side follow each other with few gaps.
  bool is_dense(Index k, Index length) const {
    constexpr double kLoose = 2;
    return time(k + length + side() - 1) - time(k - side()) <=
           kLoose * static_cast<double>(length + 2 * side() - 1) * period_;
  }

  Surroundings around(Index k, Index length, const Eigen::Matrix3Xd& positions,
                      size_t count) const {
    const auto of = [&](Index n) -> Vector3d {
      return positions.col(good_[static_cast<size_t>(n)]);
    };
    Surroundings result{};
    result.count = count;
    for (size_t j = 0; j < count; ++j) {
      const auto away = static_cast<Index>(j);
      result.before[j] = time(k - 1 - away);
      result.before_at[j] = of(k - 1 - away);
      result.after[j] = time(k + length + away);
      result.after_at[j] = of(k + length + away);
    }
    result.ends = {time(k), time(k + length - 1)};
    result.ends_at = {of(k), of(k + length - 1)};
    return result;
  }
  Surroundings around(Index k, Index length) const {
    return around(k, length, path_.position, side_);
  }

  // What the program allows for: as much as it moves there, or, if that is not known, anywhere.
  Motion motion(const Run& run) {
    if (wanted_) {
      const Surroundings near = around(run.first, run.length, *wanted_, kSideOfMotion);
      Motion most;
      for (const size_t end : {size_t{0}, size_t{1}}) {
        most.both = std::max(most.both, near.both(end).off());
        for (const Difference& side : near.sides(end)) most.side = std::max(most.side, side.off());
      }
      return most;
    }
    std::optional<Motion>& value = motion_[static_cast<size_t>(run.length - 1)];
    if (!value) value = armtrue::departures(programmed_, period_, run.length);
    return *value;
  }

  // The noise of a sample per axis, from how samples differ from their neighbours: the median, of
  // the whole record and of the stretch where a sample lies, which may shake more.
  void find_noise() {
    constexpr Index kStretch = 64;
    // |.|^2 of three normal components has this median.
    constexpr double kMedian = 2.365974;
    const auto from_squares = [](std::vector<double> squares) {
      return squares.empty() ? 0 : std::sqrt(median(std::move(squares)) / kMedian);
    };
    std::vector<double> all;
    std::vector<std::vector<double>> stretches(static_cast<size_t>(size() / kStretch + 1));
    for (Index k = side(); k + side() < size(); ++k) {
      const Difference both = around(k, 1).both(0);
      all.push_back(std::pow(both.off() / both.deviation, 2));
      stretches[static_cast<size_t>(k / kStretch)].push_back(all.back());
    }
    usual_ = std::max(rounding_, from_squares(std::move(all)));
    noise_.assign(stretches.size(), usual_);
    for (size_t s = 0; s < stretches.size(); ++s) {
      std::vector<double> near;
      for (size_t n = s > 0 ? s - 1 : 0; n <= std::min(s + 1, stretches.size() - 1); ++n)
        near.insert(near.end(), stretches[n].begin(), stretches[n].end());
      noise_[s] = std::max(usual_, from_squares(std::move(near)));
    }
    stretch_ = kStretch;
    threshold_ = normal_length_exceeded(kChance / static_cast<double>(size()));
  }
  double noise(Index k) const { return noise_[static_cast<size_t>(k / stretch_)]; }

  std::vector<Run> departures() {
    std::vector<Run> candidates;
    for (Index length = 1; length <= longest_run(); ++length)
      for (Index k = side(); k + length + side() <= size(); ++k) {
        if (!is_dense(k, length)) continue;
        const Surroundings near = around(k, length);
        double least = std::numeric_limits<double>::infinity();
        for (const size_t end : {size_t{0}, size_t{1}}) {
          const Difference both = near.both(end);
          least = std::min(least, both.off() / allowed(both.deviation, threshold_, noise(k)));
        }
        if (least > 1) candidates.push_back({k, length, 0});
      }
    // These stand out; which of them neither side explains is asked only as often.
    const double confirmed = normal_length_exceeded(
        kChance / static_cast<double>(std::max<size_t>(1, candidates.size())));
    std::vector<Run> runs;
    for (Run run : candidates) {
      const Surroundings near = around(run.first, run.length);
      const Motion own = motion(run);
      run.excess = std::numeric_limits<double>::infinity();
      for (const size_t end : {size_t{0}, size_t{1}}) {
        const auto compare = [&](const Difference& difference, double threshold, double by_itself) {
          const double chance = allowed(difference.deviation, threshold, noise(run.first));
          run.excess = std::min(run.excess, difference.off() / (chance + by_itself));
        };
        compare(near.both(end), threshold_, own.both);
        const auto sides = near.sides(end);
        // What departs and comes back is further off than the sides are from each other; on the way
        // from one to the other a tool may turn.
        const double step = wanted_ ? (near.before_at[0] - near.after_at[0]).norm()
                                    : (sides[0].vector - sides[1].vector).norm();
        for (const Difference& side : sides) {
          compare(side, confirmed, own.side);
          run.excess = std::min(run.excess, side.off() / step);
        }
      }
      if (run.excess > 1) runs.push_back(run);
    }
    if (!wanted_) add_ends(runs);
    return runs;
  }

  static double allowed(double deviation, double threshold, double noise) {
    return std::max(kFreePlay, threshold * deviation * noise);
  }

  // Near an end of the record one side is missing. The other has to be off its line, and further
  // than the tool travels.
  void add_ends(std::vector<Run>& runs) const {
    for (const bool at_start : {true, false})
      for (Index length = 1; length <= longest_run(); ++length)
        for (Index skipped = 0; skipped + length <= side(); ++skipped) {
          const Index first = at_start ? skipped : size() - skipped - length;
          const Index inner = at_start ? first + length : first - 1;  // the next good one
          std::array<double, kMaxSide> times{};
          std::array<Vector3d, kMaxSide> others;
          for (size_t j = 0; j < side_; ++j) {
            const auto away = static_cast<Index>(j);
            times[j] = time(at_start ? inner + away : inner - away);
            others[j] = at(at_start ? inner + away : inner - away);
          }
          double least = std::numeric_limits<double>::infinity();
          const auto jump = [&](Index k, Index other) {
            const double travel = speed_ * std::abs(time(k) - time(other));
            const double chance = allowed(std::numbers::sqrt2, threshold_, noise(k));
            least = std::min(least, (at(k) - at(other)).norm() / (travel + chance));
          };
          const Index last = first + length - 1;
          jump(at_start ? last : first, inner);
          if (skipped > 0 && at_start) jump(first, first - 1);
          if (skipped > 0 && !at_start) jump(last, last + 1);
          for (const Index k : {first, last}) {
            const Difference line = from_line(time(k), at(k), times.data(), others.data(), side_);
            least = std::min(least, line.off() / allowed(line.deviation, threshold_, noise(k)));
          }
          if (least > 1) runs.push_back({first, length, least});
        }
  }

  // The clearest first; what lies beside one has to be looked at again without it.
  bool remove(std::vector<Run> runs) {
    std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
      return a.excess != b.excess ? a.excess > b.excess : a.length < b.length;
    });
    std::vector<bool> touched(good_.size(), false), bad(good_.size(), false);
    for (const Run& run : runs) {
      const Index from = std::max<Index>(0, run.first - side());
      const Index to = std::min(size(), run.first + run.length + side());
      if (std::any_of(touched.begin() + from, touched.begin() + to, [](bool t) { return t; }))
        continue;
      std::fill(touched.begin() + from, touched.begin() + to, true);
      std::fill(bad.begin() + run.first, bad.begin() + run.first + run.length, true);
    }
    std::vector<Index> kept;
    for (size_t k = 0; k < good_.size(); ++k)
      if (!bad[k]) kept.push_back(good_[k]);
    good_.swap(kept);
    return !runs.empty();
  }

  const Path& programmed_;
  const Path& path_;
  const Eigen::Matrix3Xd* wanted_ = nullptr;
  double period_, speed_ = 0;
  size_t side_;
  std::vector<Index> good_;
  double rounding_;            // part of the noise that the median may not show
  std::vector<double> noise_;  // by stretch
  double usual_ = 0, threshold_ = 0;
  Index stretch_ = 1;
  std::array<std::optional<Motion>, kFew> motion_;
};

}  // namespace

WithoutDepartures without_departures(const Path& programmed, const Path& measured, double speed,
                                     double rounding, std::vector<Index> good) {
  DepartureFilter filter(programmed, measured, speed, rounding, std::move(good));
  std::vector<Index> left = filter.good_samples();
  return {std::move(left), filter.tolerance()};
}

WithoutDepartures without_departures(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                     double rounding, std::vector<Index> good) {
  DepartureFilter filter(deviation, wanted, rounding, std::move(good));
  std::vector<Index> left = filter.good_samples();
  return {std::move(left), filter.tolerance()};
}

}  // namespace armtrue
