#include "armtrue/path/bad_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "armtrue/statistics/summary.h"
#include "trend.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr Index kFew = 3;                    // consecutive samples
constexpr double kLargestDeviation = 10e-3;  // [m] of a tool from its program
constexpr double kFreePlay = 0.4e-3;         // [m]: a loose or sticking tool moves as suddenly
constexpr double kQuick = 0.25;              // [s]: an arm takes longer to go out and come back
constexpr double kChance = 1e-3;             // of calling any sample bad in a record without
constexpr double kShareTooMany = 0.1;

// The length that vectors of three normal components of unit variance exceed with this probability.
double normal_length_exceeded(double probability) {
  const auto exceeds = [](double r) {
    return std::erfc(r / std::numbers::sqrt2) +
           std::sqrt(2 / std::numbers::pi) * r * std::exp(-0.5 * r * r);
  };
  double low = 0, high = 40;
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    (exceeds(middle) > probability ? low : high) = middle;
  }
  return high;
}

bool earlier(const BadSample& a, const BadSample& b) { return a.sample < b.sample; }

// --- Frozen readings: an instrument that hangs repeats its last one while the tool goes on.

// Samples that show the same.
struct Hold {
  Index first, last;
};

// Where the instrument repeats a reading more than twice as often as it usually does: one that is
// asked more often than it measures repeats all of them.
std::vector<Hold> long_holds(const Eigen::Matrix3Xd& readings) {
  std::vector<Hold> holds;
  std::vector<double> lengths;
  Index first = 0;
  for (Index i = 1; i <= readings.cols(); ++i) {
    if (i < readings.cols() && (readings.col(i) - readings.col(first)).norm() <= kStandstill)
      continue;
    lengths.push_back(static_cast<double>(i - first));
    holds.push_back({first, i - 1});
    first = i;
  }
  const double usual = median(std::move(lengths));
  std::erase_if(holds, [&](const Hold& hold) {
    return static_cast<double>(hold.last - hold.first + 1) <= 2 * usual;
  });
  return holds;
}

// The standard deviation per axis of what an instrument rounds away: coordinates that change at all
// change by no less than it rounds to.
double rounding(const Eigen::Matrix3Xd& readings) {
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 1; i < readings.cols(); ++i)
    for (const double step : Vector3d(readings.col(i) - readings.col(i - 1)))
      if (std::abs(step) > kStandstill) least = std::min(least, std::abs(step));
  return std::isfinite(least) ? least / std::sqrt(12) : 0;
}

// All samples but those that only repeat a reading: the one that ends the hold is further away than
// the tool gets by itself in that time, but not than since the reading that is repeated. A tool
// that stood goes on slowly, and a coarse instrument by the step that it rounds to. `travel` is how
// far the tool gets at most from one sample to another; `left` says whether it had left at a sample
// if it got so far until another.
template <class Travel, class Left>
std::vector<Index> not_frozen(const Eigen::Matrix3Xd& readings, const Travel& travel,
                              const Left& left) {
  const Index count = readings.cols();
  std::vector<bool> frozen(static_cast<size_t>(count), false);
  const std::vector<Hold> holds = long_holds(readings);
  const double noise = holds.empty() ? 0 : std::max(rounding(readings), white_noise(readings));
  const double chance =
      normal_length_exceeded(kChance / static_cast<double>(count)) * std::numbers::sqrt2 * noise;
  for (const auto& [first, last] : holds) {
    const Index next = last + 1;
    if (next == count) continue;  // it may be the tool that stays
    const double jump = (readings.col(next) - readings.col(last)).norm();
    if (jump <= travel(last, next) + std::max(kFreePlay, chance) ||
        jump > travel(first, next) + kLargestDeviation)
      continue;
    for (Index k = first + 1; k <= last; ++k) frozen[static_cast<size_t>(k)] = left(k, next, jump);
  }
  std::vector<Index> rest;
  for (Index k = 0; k < count; ++k)
    if (!frozen[static_cast<size_t>(k)]) rest.push_back(k);
  return rest;
}

// --- Lost locks: what leaves and comes back by jumps that no tool can make.

struct Piece {
  Index first, last;
};

class JumpFilter {
 public:
  JumpFilter(const Path& path, double speed, const std::vector<Index>& samples)
      : path_(path), speed_(speed), samples_(samples) {
    for (Index k = 0; k < static_cast<Index>(samples.size()); ++k) {
      if (k == 0 || !reaches(k - 1, k)) pieces_.push_back({k, k});
      pieces_.back().last = k;
    }
    kept_.assign(pieces_.size(), false);
  }

  std::vector<Index> good_samples() {
    size_t longest = 0;
    for (size_t k = 1; k < pieces_.size(); ++k)
      if (is_zero(longest) || (length(k) > length(longest) && !is_zero(k))) longest = k;
    kept_[longest] = true;
    follow(longest, 1);
    follow(longest, -1);
    std::vector<Index> good;
    for (size_t k = 0; k < pieces_.size(); ++k)
      for (Index i = pieces_[k].first; kept_[k] && i <= pieces_[k].last; ++i)
        good.push_back(sample(i));
    return good;
  }

 private:
  Index sample(Index k) const { return samples_[static_cast<size_t>(k)]; }
  Index length(size_t k) const { return pieces_[k].last - pieces_[k].first + 1; }
  // Instruments write zeros while they see nothing.
  bool is_zero(size_t k) const { return path_.position.col(sample(pieces_[k].first)).isZero(0); }
  bool reaches(Index a, Index b) const {
    const double duration = std::abs(path_.time[sample(b)] - path_.time[sample(a)]);
    return (path_.position.col(sample(b)) - path_.position.col(sample(a))).norm() <=
           kLargestDeviation + speed_ * duration;
  }

  // From a good piece to those that the tool may have gone on to. Where none follows, the record
  // stays away: such a step is not for this filter to judge.
  void follow(size_t from, int direction) {
    const auto end = static_cast<std::ptrdiff_t>(direction > 0 ? pieces_.size() : size_t(-1));
    const auto near = [&](size_t k) { return direction > 0 ? pieces_[k].first : pieces_[k].last; };
    const auto far = [&](size_t k) { return direction > 0 ? pieces_[k].last : pieces_[k].first; };
    size_t good = from;
    for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(from) + direction; k != end;
         k += direction) {
      const auto piece = static_cast<size_t>(k);
      if (is_zero(piece) || !reaches(far(good), near(piece))) continue;
      kept_[piece] = true;
      good = piece;
    }
    for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(good) + direction; k != end;
         k += direction) {
      const auto piece = static_cast<size_t>(k);
      kept_[piece] = length(piece) > kFew && !is_zero(piece);
    }
  }

  const Path& path_;
  double speed_;
  const std::vector<Index>& samples_;
  std::vector<Piece> pieces_;  // by the place of their samples
  std::vector<bool> kept_;
};

// --- Departures: a few samples that neither side explains.

constexpr size_t kMostSide = 6;  // samples on either side that say where the tool was

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
  std::array<double, kMostSide> before, after;
  std::array<Vector3d, kMostSide> before_at, after_at;
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
  // The record as it is: how the program moves at a sample is not known yet.
  DepartureFilter(const Path& programmed, const Path& measured, double speed, double rounding,
                  std::vector<Index> good)
      : programmed_(programmed),
        path_(measured),
        period_(median_period(measured)),
        speed_(speed),
        side_(kSideOfMotion),
        good_(std::move(good)),
        rounding_(rounding) {}

  // Deviations from `wanted`, which change little: more neighbours tell where the tool was.
  DepartureFilter(const Path& deviation, const Eigen::Matrix3Xd& wanted, double rounding,
                  std::vector<Index> good)
      : programmed_(deviation),
        path_(deviation),
        wanted_(&wanted),
        period_(median_period(deviation)),
        side_(kMostSide),
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

  // Of samples that differ from their good neighbours by chance only.
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
          std::array<double, kMostSide> times{};
          std::array<Vector3d, kMostSide> others;
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

// Samples that are not good, and how far off: from the straight line between the good ones beside
// them, or from the only one.
std::vector<BadSample> the_others(const Path& path, const std::vector<Index>& good) {
  std::vector<BadSample> bad;
  size_t next = 0;
  for (Index i = 0; i < path.samples(); ++i) {
    if (next < good.size() && good[next] == i) {
      ++next;
      continue;
    }
    Vector3d expected = Vector3d::Zero();
    if (next == 0) {
      expected = path.position.col(good.front());
    } else if (next == good.size()) {
      expected = path.position.col(good.back());
    } else {
      const Index a = good[next - 1], b = good[next];
      const double share = (path.time[i] - path.time[a]) / (path.time[b] - path.time[a]);
      expected = (1 - share) * path.position.col(a) + share * path.position.col(b);
    }
    bad.push_back({i, (path.position.col(i) - expected).norm()});
  }
  return bad;
}

// Between two bad ones a good one looks bad, too, until they are gone, and a repeated reading does
// until its deviation is known.
std::vector<BadSample> reinstated(std::vector<BadSample> bad, double tolerance) {
  std::erase_if(bad, [&](const BadSample& b) { return b.off <= tolerance; });
  return bad;
}

}  // namespace

std::vector<BadSample> find_bad_samples(const Path& programmed, const Path& measured) {
  if (measured.samples() < 2) return {};
  const double period = median_period(measured);
  const double speed = longest_move(programmed, period) / period;
  const auto travel = [&](Index from, Index to) {
    return speed * (measured.time[to] - measured.time[from]);
  };
  const auto left = [&](Index k, Index next, double jump) { return jump > travel(k, next); };
  const std::vector<Index> live = not_frozen(measured.position, travel, left);
  DepartureFilter filter(programmed, measured, speed, rounding(measured.position),
                         JumpFilter(measured, speed, live).good_samples());
  return reinstated(the_others(measured, filter.good_samples()), filter.tolerance());
}

std::vector<BadSample> find_bad_deviations(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                           const std::vector<BadSample>& known) {
  if (deviation.samples() < 2) return {};
  // Along the program; a sample more on either side, for the clock may be off by as much.
  const auto travel = [&](Index from, Index to) {
    double length = 0;
    for (Index i = std::max<Index>(from, 1); i <= std::min(to + 1, deviation.samples() - 1); ++i)
      length += (wanted.col(i) - wanted.col(i - 1)).norm();
    return length;
  };
  const auto left = [](Index, Index, double) { return true; };  // see reinstated()
  Eigen::Matrix3Xd readings = deviation.position + wanted;
  const double rounded = rounding(readings);
  std::vector<Index> live = not_frozen(readings, travel, left);
  readings.resize(3, 0);  // for the memory
  std::erase_if(live, [&](Index i) {
    return std::binary_search(known.begin(), known.end(), BadSample{i, 0}, earlier);
  });
  DepartureFilter filter(deviation, wanted, rounded, std::move(live));
  return reinstated(the_others(deviation, filter.good_samples()), filter.tolerance());
}

bool too_many(const std::vector<BadSample>& bad, const Path& measured) {
  return static_cast<double>(bad.size()) > kShareTooMany * static_cast<double>(measured.samples());
}

TooManyBadSamples::TooManyBadSamples(size_t which, std::vector<BadSample> those)
    : std::invalid_argument("pass " + std::to_string(which + 1) + ": " +
                            std::to_string(those.size()) +
                            " samples are no readings of the tool, which does not move so: more "
                            "than a tenth; measure the pass again"),
      pass(which),
      bad(std::move(those)) {}

Path without(const Path& path, const std::vector<BadSample>& bad) {
  if (bad.empty()) return path;
  std::vector<bool> good(static_cast<size_t>(path.samples()), true);
  for (const BadSample& b : bad) good[static_cast<size_t>(b.sample)] = false;
  std::vector<Index> kept;
  for (Index i = 0; i < path.samples(); ++i)
    if (good[static_cast<size_t>(i)]) kept.push_back(i);
  Path rest;
  rest.time = path.time(kept);
  rest.position = path.position(Eigen::all, kept);
  if (path.has_orientation()) rest.orientation = path.orientation(Eigen::all, kept);
  if (path.has_joints()) rest.q = path.q(Eigen::all, kept);
  if (path.has_force()) rest.force = path.force(Eigen::all, kept);
  return rest;
}

}  // namespace armtrue
