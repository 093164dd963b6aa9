#include "path/samples/departures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "armtrue/statistics/summary.h"
#include "path/samples/neighbours.h"
#include "path/samples/plausible_motion.h"
#include "path/samples/program_departure.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kMinReturn = 0.25;  // [s]: an arm takes longer to go out and come back

// Removes departed samples from the good ones, round by round. The motion of the program at a
// sample, and the treatment of the ends of the record, depend on whether the record is registered:
// see the two filters below.
class DepartureFilter {
 public:
  virtual ~DepartureFilter() = default;

  WithoutDepartures run() {
    while (size() > 4 * side() && !crowded()) {
      find_noise();
      if (!remove(departed_runs())) break;
    }
    return {good_, std::max(kFreePlay, threshold_ * std::sqrt(1.5) * usual_)};
  }

 protected:
  struct Run {
    Index first, length;  // among the good samples
    double excess;        // smallest ratio of a difference to what is allowed
  };

  DepartureFilter(const Path& path, size_t side, double rounding, std::vector<Index> good)
      : path_(path),
        period_(median_period(path)),
        side_(side),
        good_(std::move(good)),
        rounding_(rounding) {}

  // How far the program itself departs at a run.
  virtual Departure own_departure(const Run& run) = 0;
  // How far the sides of a run lie from each other at one of its ends [m].
  virtual double step_between(const Neighbours& near,
                              const std::array<NeighbourDifference, 2>& sides) const = 0;
  virtual void add_ends(std::vector<Run>& runs) const = 0;

  int size() const { return static_cast<int>(good_.size()); }
  Index side() const { return side_; }
  double period() const { return period_; }
  double threshold() const { return threshold_; }
  double time(Index k) const { return path_.time[good_[k]]; }
  Vector3d at(Index k) const { return path_.position.col(good_[k]); }
  double noise(Index k) const { return noise_[k / kStretch]; }

  Index longest_run() const {
    return std::min(kMaxRun, static_cast<Index>(std::floor(kMinReturn / period_)) - 1);
  }

  // The neighbours of a run of good samples, `count` on either side, with other positions.
  Neighbours around(Index k, Index length, const Eigen::Matrix3Xd& positions, size_t count) const {
    const auto of = [&](Index n) -> Vector3d { return positions.col(good_[n]); };
    Neighbours result{};
    result.count = count;
    for (size_t j = 0; j < count; ++j) {
      const Index away = j;
      result.before[j] = time(k - 1 - away);
      result.before_at[j] = of(k - 1 - away);
      result.after[j] = time(k + length + away);
      result.after_at[j] = of(k + length + away);
    }
    result.ends = {time(k), time(k + length - 1)};
    result.ends_at = {of(k), of(k + length - 1)};
    return result;
  }

  // Difference by chance and free play [m].
  static double allowed(double deviation, double threshold, double noise) {
    return std::max(kFreePlay, threshold * deviation * noise);
  }

 private:
  static constexpr Index kStretch = 64;  // samples with one estimate of the noise

  bool crowded() const { return path_.samples() - size() > kMaxBadShare * path_.samples(); }

  // Whether the neighbours of a run follow each other with few gaps.
  bool is_dense(Index k, Index length) const {
    constexpr double kMaxStretching = 2;  // of the time that they would take without gaps
    return time(k + length + side() - 1) - time(k - side()) <=
           kMaxStretching * static_cast<double>(length + 2 * side() - 1) * period_;
  }

  Neighbours around(Index k, Index length) const {
    return around(k, length, path_.position, side_);
  }

  // Estimates the noise of a sample per axis from the differences between samples and their
  // neighbours: their median over the whole record, or, if that is more, over the three stretches
  // around a sample, where the tool may shake.
  void find_noise() {
    constexpr double kMedian = 2.365974;  // of chi^2 with three degrees of freedom
    const auto from_squares = [](std::vector<double> squares) {
      return squares.empty() ? 0 : std::sqrt(median(std::move(squares)) / kMedian);
    };
    std::vector<double> all;
    std::vector<std::vector<double>> stretches(size() / kStretch + 1);
    for (Index k = side(); k + side() < size(); ++k) {
      const NeighbourDifference both = around(k, 1).from_both_sides(0);
      all.push_back(std::pow(both.length() / both.deviation, 2));
      stretches[k / kStretch].push_back(all.back());
    }
    usual_ = std::max(rounding_, from_squares(std::move(all)));
    noise_.assign(stretches.size(), usual_);
    for (size_t s = 0; s < stretches.size(); ++s) {
      std::vector<double> near;
      for (size_t n = s > 0 ? s - 1 : 0; n <= std::min(s + 1, stretches.size() - 1); ++n)
        near.insert(near.end(), stretches[n].begin(), stretches[n].end());
      noise_[s] = std::max(usual_, from_squares(std::move(near)));
    }
    threshold_ = normal_length_exceeded(kChance / size());
  }

  // Runs that differ from both sides by more than chance.
  std::vector<Run> candidates() const {
    std::vector<Run> found;
    for (Index length = 1; length <= longest_run(); ++length)
      for (Index k = side(); k + length + side() <= size(); ++k) {
        if (!is_dense(k, length)) continue;
        const Neighbours near = around(k, length);
        double least = std::numeric_limits<double>::infinity();
        for (const size_t end : {size_t{0}, size_t{1}}) {
          const NeighbourDifference both = near.from_both_sides(end);
          least = std::min(least, both.length() / allowed(both.deviation, threshold_, noise(k)));
        }
        if (least > 1) found.push_back({k, length, 0});
      }
    return found;
  }

  // The smallest ratio of the differences of a run to what chance (from a single side: `threshold`)
  // and the program itself allow for.
  double excess(const Run& run, double threshold) {
    const Neighbours near = around(run.first, run.length);
    const Departure own = own_departure(run);
    double least = std::numeric_limits<double>::infinity();
    const auto compare = [&](const NeighbourDifference& difference, double factor,
                             double by_itself) {
      const double chance = allowed(difference.deviation, factor, noise(run.first));
      least = std::min(least, difference.length() / (chance + by_itself));
    };
    for (const size_t end : {size_t{0}, size_t{1}}) {
      compare(near.from_both_sides(end), threshold_, own.both);
      const auto sides = near.from_each_side(end);
      // A sample that departs and comes back is further off than the sides are from each other; a
      // tool that goes from one to the other may turn on its way.
      const double step = step_between(near, sides);
      for (const NeighbourDifference& side : sides) {
        compare(side, threshold, own.side);
        least = std::min(least, side.length() / step);
      }
    }
    return least;
  }

  std::vector<Run> departed_runs() {
    std::vector<Run> runs;
    const std::vector<Run> those = candidates();
    // Only the candidates are compared with single sides: chance has fewer occasions.
    const double threshold =
        normal_length_exceeded(kChance / static_cast<double>(std::max<size_t>(1, those.size())));
    for (Run run : those) {
      run.excess = excess(run, threshold);
      if (run.excess > 1) runs.push_back(run);
    }
    add_ends(runs);
    return runs;
  }

  // Removes runs from the good samples, the clearest first. Runs beside a removed one are tested in
  // the next round, without it. Returns whether it removed any.
  bool remove(std::vector<Run> runs) {
    std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
      return a.excess != b.excess ? a.excess > b.excess : a.length < b.length;
    });
    std::vector<bool> touched(good_.size(), false), bad(good_.size(), false);
    for (const Run& run : runs) {
      const Index from = std::max<Index>(0, run.first - side());
      const Index to = std::min<Index>(size(), run.first + run.length + side());
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

  const Path& path_;
  double period_;
  size_t side_;  // samples on either side that show where the tool was
  std::vector<Index> good_;
  double rounding_;            // part of the noise that the median may not show
  std::vector<double> noise_;  // by stretch
  double usual_ = 0;           // noise of the whole record
  double threshold_ = 0;       // standard deviations that a run in this record may differ by chance
};

// Filters a record that is not registered. The place of the program at a sample is not known, so
// the largest departure of the whole program is allowed.
class RecordFilter final : public DepartureFilter {
 public:
  RecordFilter(const Path& programmed, const Path& measured, double speed, double rounding,
               std::vector<Index> good)
      : DepartureFilter(measured, kSideOfMotion, rounding, std::move(good)),
        programmed_(programmed),
        speed_(speed) {}

 private:
  Departure own_departure(const Run& run) override {
    std::optional<Departure>& value = largest_[run.length - 1];
    if (!value) value = largest_departure(programmed_, period(), run.length);
    return *value;
  }

  double step_between(const Neighbours& /*near*/,
                      const std::array<NeighbourDifference, 2>& sides) const override {
    return (sides[0].vector - sides[1].vector).norm();
  }

  // Adds runs near an end of the record, where one side is missing. Such a run has to be off the
  // line of the other side, and further from its neighbours than the tool travels.
  void add_ends(std::vector<Run>& runs) const override {
    for (const bool at_start : {true, false})
      for (Index length = 1; length <= longest_run(); ++length)
        for (Index skipped = 0; skipped + length <= side(); ++skipped) {
          const Index first = at_start ? skipped : size() - skipped - length;
          const Index inner = at_start ? first + length : first - 1;  // the next good one
          std::array<double, kSideOfMotion> times{};
          std::array<Vector3d, kSideOfMotion> others;
          for (size_t j = 0; j < kSideOfMotion; ++j) {
            const Index away = j;
            times[j] = time(at_start ? inner + away : inner - away);
            others[j] = at(at_start ? inner + away : inner - away);
          }
          double least = std::numeric_limits<double>::infinity();
          const auto jump = [&](Index k, Index other) {
            const double travel = speed_ * std::abs(time(k) - time(other));
            const double chance = allowed(std::numbers::sqrt2, threshold(), noise(k));
            least = std::min(least, (at(k) - at(other)).norm() / (travel + chance));
          };
          const Index last = first + length - 1;
          jump(at_start ? last : first, inner);
          if (skipped > 0 && at_start) jump(first, first - 1);
          if (skipped > 0 && !at_start) jump(last, last + 1);
          for (const Index k : {first, last}) {
            const NeighbourDifference line = difference_from_line(time(k), at(k), times, others);
            least = std::min(least, line.length() / allowed(line.deviation, threshold(), noise(k)));
          }
          if (least > 1) runs.push_back({first, length, least});
        }
  }

  const Path& programmed_;
  double speed_;
  std::array<std::optional<Departure>, kMaxRun> largest_;  // by the length of the run
};

// Filters deviations, whose program is known at each sample.
class DeviationFilter final : public DepartureFilter {
 public:
  DeviationFilter(const Path& deviation, const Eigen::Matrix3Xd& wanted, double rounding,
                  std::vector<Index> good)
      : DepartureFilter(deviation, kMaxSide, rounding, std::move(good)), wanted_(wanted) {}

 private:
  Departure own_departure(const Run& run) override {
    const Neighbours near = around(run.first, run.length, wanted_, kSideOfMotion);
    Departure most;
    for (const size_t end : {size_t{0}, size_t{1}}) {
      most.both = std::max(most.both, near.from_both_sides(end).length());
      for (const NeighbourDifference& side : near.from_each_side(end))
        most.side = std::max(most.side, side.length());
    }
    return most;
  }

  double step_between(const Neighbours& near,
                      const std::array<NeighbourDifference, 2>& /*sides*/) const override {
    return (near.before_at[0] - near.after_at[0]).norm();
  }

  // A record is registered only once its ends are clean.
  void add_ends(std::vector<Run>& /*runs*/) const override {}

  const Eigen::Matrix3Xd& wanted_;
};

}  // namespace

WithoutDepartures without_departures(const Path& programmed, const Path& measured, double speed,
                                     double rounding, std::vector<Index> good) {
  return RecordFilter(programmed, measured, speed, rounding, std::move(good)).run();
}

WithoutDepartures without_departures(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                     double rounding, std::vector<Index> good) {
  return DeviationFilter(deviation, wanted, rounding, std::move(good)).run();
}

}  // namespace armtrue
