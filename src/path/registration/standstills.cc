#include "armtrue/path/registration/standstills.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include "armtrue/statistics/summary.h"
#include "path/registration/first_offset.h"

namespace armtrue {
namespace {

constexpr double kShortest = 0.5;       // [s] of a standstill, and the span that is looked at
constexpr double kGap = 3;              // median distances of two samples
constexpr double kCreep = 3;            // tolerances
constexpr double kCalmest = 0.1;        // share of the spans
constexpr double kRestFactor = 3;       // of their extent
constexpr double kSmallestRest = 5e-5;  // [m]
constexpr double kLargestRate = 2.5 * kRateSigma;
constexpr size_t kMaxReadings = 200;  // that the offset is searched with
constexpr size_t kMaxMatches = 50;    // of which clocks are refined
// More readings are searched in runs of successive ones: as many runs, spread over the record, that
// one lies where the records overlap, if they overlap by more than a quarter. Even where standstills
// fill half of the time, no wrong offset meets much more than two thirds of a run.
constexpr size_t kRuns = 4, kReadingsOfRun = 100;

// The offsets of one rate that are looked at: at most so many peaks, which have at least this share
// of the pairs of the highest. A program that repeats itself fits a run, but not all readings, at
// each of its cycles.
struct PeakChoice {
  size_t most;
  double share;
};
constexpr PeakChoice kPeaksOfAll{20, 0.5}, kPeaksOfRun{200, 0.8};

// For each sample the last one of the span of kShortest that begins there; -1 behind the last span.
std::vector<Eigen::Index> span_ends(const Eigen::VectorXd& times) {
  const Eigen::Index n = times.size();
  std::vector<Eigen::Index> ends(n, -1);
  Eigen::Index end = 0;
  for (Eigen::Index begin = 0; begin < n; ++begin) {
    while (end < n && times[end] < times[begin] + kShortest) ++end;
    if (end == n) break;
    ends[begin] = end;
  }
  return ends;
}

// Longest time between two samples of one continuous record: samples may be lost.
double longest_gap(const Eigen::VectorXd& times) {
  std::vector<double> gaps;
  for (Eigen::Index k = 1; k < times.size(); ++k) gaps.push_back(times[k] - times[k - 1]);
  return gaps.empty() ? kShortest : std::max(kShortest, kGap * median(gaps));
}

// Whether samples are missing in a span.
bool has_gap(const Eigen::VectorXd& times, Eigen::Index begin, Eigen::Index end, double longest) {
  for (Eigen::Index k = begin; k < end; ++k)
    if (times[k + 1] - times[k] > longest) return true;
  return false;
}

Eigen::VectorXd extent(const Eigen::Ref<const Eigen::MatrixXd>& values, Eigen::Index begin,
                       Eigen::Index end) {
  const auto span = values.middleCols(begin, end - begin + 1);
  return span.rowwise().maxCoeff() - span.rowwise().minCoeff();
}

// The offsets under which a reading lies within a standstill.
struct Allowed {
  double low, high;
};

Allowed allowed_offsets(const Standstill& standstill, const Standstill& reading, double rate,
                        double tolerance) {
  return {reading.end - (1 + rate) * standstill.end - tolerance,
          reading.begin - (1 + rate) * standstill.begin + tolerance};
}

// The offsets at which most pairs overlap, for one rate: the highest peaks kShortest apart.
std::vector<ClockFit> likely_clocks(const std::vector<Standstill>& standstills,
                                    const std::vector<Standstill>& readings, double rate,
                                    double tolerance, const PeakChoice& choice) {
  std::vector<std::pair<double, int>> bounds;
  for (const Standstill& reading : readings)
    for (const Standstill& standstill : standstills) {
      const Allowed allowed = allowed_offsets(standstill, reading, rate, tolerance);
      if (allowed.low > allowed.high) continue;
      bounds.emplace_back(allowed.low, 1);
      bounds.emplace_back(allowed.high, -1);
    }
  std::ranges::sort(bounds, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  });
  struct Peak {
    double offset;
    int pairs;
  };
  std::vector<Peak> peaks;
  int pairs = 0;
  for (size_t k = 0; k + 1 < bounds.size(); ++k) {
    pairs += bounds[k].second;
    if (bounds[k].second > 0 && bounds[k + 1].second < 0)
      peaks.push_back({0.5 * (bounds[k].first + bounds[k + 1].first), pairs});
  }
  std::ranges::stable_sort(peaks, [](const Peak& a, const Peak& b) { return a.pairs > b.pairs; });
  std::vector<ClockFit> clocks;
  for (const Peak& peak : peaks) {
    if (clocks.size() == choice.most || peak.pairs < choice.share * peaks.front().pairs) break;
    const auto near = [&](const ClockFit& clock) {
      return std::abs(clock.offset - peak.offset) < kShortest;
    };
    if (std::ranges::any_of(clocks, near)) continue;
    ClockFit& clock = clocks.emplace_back();
    clock.offset = peak.offset;
    clock.rate = rate;
  }
  return clocks;
}

double middle(const Standstill& span) { return 0.5 * (span.begin + span.end); }

// Weighted least squares of offset (at the middle of the record) and rate.
ClockFit refined(const std::vector<Standstill>& standstills,
                 const std::vector<Standstill>& readings, const StandstillMatch& match,
                 double tolerance) {
  double weights = 0, at = 0;
  const auto each = [&](const auto& use) {
    for (size_t k = 0; k < readings.size(); ++k) {
      if (match.standstill[k] < 0) continue;
      const Standstill& still = standstills[match.standstill[k]];
      const double play = (still.end - still.begin) - (readings[k].end - readings[k].begin);
      // Anywhere between the ends: standard deviation of a uniform distribution.
      const double deviation = (2 * tolerance + std::max(0.0, play)) / std::sqrt(12);
      use(middle(still), middle(readings[k]), 1 / (deviation * deviation));
    }
  };
  each([&](double t, double, double weight) {
    weights += weight;
    at += weight * t;
  });
  at /= weights;
  double offset = 0, rise = 0, spread = 0;
  each([&](double t, double c, double weight) { offset += weight * (c - t) / weights; });
  each([&](double t, double c, double weight) {
    spread += weight * (t - at) * (t - at);
    rise += weight * (t - at) * (c - t - offset);  // clocks may count from 1970
  });
  const double prior = 1 / (kRateSigma * kRateSigma);
  ClockFit clock;
  clock.rate = rise / (spread + prior);
  clock.offset = offset - clock.rate * at;
  clock.middle = at;
  clock.covariance(0, 0) = 1 / weights;
  clock.covariance(1, 1) = 1 / (spread + prior);
  return clock;
}

// At most kMaxReadings of those from `begin` to `end`, evenly spread.
std::vector<Standstill> spread_out(const std::vector<Standstill>& readings, size_t begin,
                                   size_t end) {
  std::vector<Standstill> some;
  const size_t all = end - begin, count = std::min(all, kMaxReadings);
  for (size_t k = 0; k < count; ++k)
    some.push_back(readings[begin + (count == 1 ? 0 : k * (all - 1) / (count - 1))]);
  return some;
}

// The clocks under which most of some readings lie within standstills. `length` is that of the time
// in which they do. The rates are so close that with one of them the error of every reading is at
// most half the tolerance.
std::vector<ClockFit> clocks_at_all_rates(const std::vector<Standstill>& standstills,
                                          const std::vector<Standstill>& readings, double length,
                                          double tolerance, const PeakChoice& choice) {
  const int steps = static_cast<int>(std::ceil(kLargestRate * length / (2 * tolerance)));
  std::vector<ClockFit> clocks;
  for (int k = -steps; k <= steps; ++k) {
    const double rate = steps == 0 ? 0 : kLargestRate * k / steps;
    for (const ClockFit& clock : likely_clocks(standstills, readings, rate, tolerance, choice))
      clocks.push_back(clock);
  }
  return clocks;
}

// A clock of the readings from `begin` to `end`, refined on ever more of those about them.
ClockFit extended(const std::vector<Standstill>& standstills,
                  const std::vector<Standstill>& readings, size_t begin, size_t end, ClockFit clock,
                  double tolerance) {
  constexpr int kFewest = 2;  // standstills that determine a clock
  while (true) {
    const std::vector<Standstill> some = spread_out(readings, begin, end);
    const StandstillMatch match = match_by_clock(standstills, some, clock, tolerance);
    if (match.standstills < kFewest) return clock;
    clock = refined(standstills, some, match, tolerance);
    if (begin == 0 && end == readings.size()) return clock;
    const size_t more = (end - begin) / 2;
    begin -= std::min(begin, more);
    end = std::min(readings.size(), end + more);
  }
}

// The likely clocks of many readings. Each is found on a run of successive ones, which is short, so
// that few rates differ there: the cost grows with the number of standstills, and not with its
// square.
std::vector<ClockFit> clocks_of_runs(const std::vector<Standstill>& standstills,
                                     const std::vector<Standstill>& readings, double tolerance) {
  std::vector<ClockFit> clocks;
  for (size_t run = 0; run < kRuns; ++run) {
    const size_t middle = (2 * run + 1) * readings.size() / (2 * kRuns);
    const size_t begin = std::min(middle - std::min(middle, kReadingsOfRun / 2),
                                  readings.size() - kReadingsOfRun);
    const size_t end = begin + kReadingsOfRun;
    const auto at = [&](size_t k) { return readings.begin() + k; };
    for (const ClockFit& clock : clocks_at_all_rates(
             standstills, {at(begin), at(end)}, readings[end - 1].end - readings[begin].begin,
             tolerance, kPeaksOfRun))
      clocks.push_back(extended(standstills, readings, begin, end, clock, tolerance));
  }
  // Those that match most of some readings, each way of matching them once.
  const std::vector<Standstill> some = spread_out(readings, 0, readings.size());
  std::vector<StandstillMatch> ways;
  std::set<std::vector<int>> known;
  for (const ClockFit& clock : clocks)
    if (StandstillMatch way = match_by_clock(standstills, some, clock, tolerance);
        known.insert(way.standstill).second)
      ways.push_back(std::move(way));
  std::ranges::stable_sort(ways, std::greater{}, &StandstillMatch::standstills);
  ways.resize(std::min(ways.size(), kMaxMatches));
  clocks.clear();
  for (const StandstillMatch& way : ways) clocks.push_back(way.clock);
  return clocks;
}

}  // namespace

std::vector<Standstill> find_standstills(const Eigen::VectorXd& times,
                                         const Eigen::MatrixXd& values,
                                         const Eigen::VectorXd& tolerance) {
  const std::vector<Eigen::Index> ends = span_ends(times);
  const double longest = longest_gap(times);
  std::vector<Standstill> found;
  Eigen::Index first = 0, last = -1;  // of the standstill that goes on; none if last < first
  const auto close = [&] {
    if (last >= first && (extent(values, first, last).array() <= kCreep * tolerance.array()).all())
      found.push_back({times[first], times[last]});
    last = -1;
    first = 0;
  };
  for (Eigen::Index begin = 0; begin < times.size(); ++begin) {
    const Eigen::Index end = ends[begin];
    if (end < 0) break;
    if (has_gap(times, begin, end, longest) ||
        (extent(values, begin, end).array() > tolerance.array()).any())
      continue;
    if (last >= first && begin <= last) {
      last = end;
      continue;
    }
    close();
    first = begin;
    last = end;
  }
  close();
  return found;
}

double rest_tolerance(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& points) {
  const std::vector<Eigen::Index> ends = span_ends(times);
  std::vector<double> extents;
  for (Eigen::Index begin = 0; begin < times.size(); ++begin)
    if (const Eigen::Index end = ends[begin]; end >= 0)
      extents.push_back(extent(points, begin, end).maxCoeff());
  if (extents.empty()) return kSmallestRest;
  return std::max(kSmallestRest, kRestFactor * quantile(std::move(extents), kCalmest));
}

StandstillMatch match_by_clock(const std::vector<Standstill>& standstills,
                               const std::vector<Standstill>& readings, const ClockFit& clock,
                               double tolerance) {
  StandstillMatch match;
  match.clock = clock;
  std::set<int> used;
  for (const Standstill& reading : readings) {
    // The standstills whose time may hold the reading are neighbours: that which begins last before
    // its middle, and the next.
    const double at = clock.program_time(middle(reading));
    const auto next = std::ranges::upper_bound(standstills, at, {}, &Standstill::begin);
    int best = -1;
    double least = 0;
    for (auto one = next == standstills.begin() ? next : next - 1;
         one != standstills.end() && one <= next; ++one) {
      const Allowed allowed = allowed_offsets(*one, reading, clock.rate, tolerance);
      if (clock.offset < allowed.low || clock.offset > allowed.high) continue;
      const double off = std::abs(middle(*one) - at);
      if (best >= 0 && off >= least) continue;
      best = static_cast<int>(one - standstills.begin());
      least = off;
    }
    match.standstill.push_back(best);
    if (best >= 0) used.insert(best);
  }
  match.standstills = static_cast<int>(used.size());
  return match;
}

std::vector<StandstillMatch> match_standstills(const std::vector<Standstill>& standstills,
                                               const std::vector<Standstill>& readings,
                                               double tolerance) {
  if (standstills.empty() || readings.empty()) return {};
  const double length = std::max(standstills.back().end - standstills.front().begin,
                                 readings.back().end - readings.front().begin);
  std::vector<StandstillMatch> matches;
  for (const ClockFit& clock :
       readings.size() > kMaxReadings
           ? clocks_of_runs(standstills, readings, tolerance)
           : clocks_at_all_rates(standstills, readings, length, tolerance, kPeaksOfAll))
    matches.push_back(match_by_clock(standstills, readings, clock, tolerance));
  const auto most_first = [](const StandstillMatch& a, const StandstillMatch& b) {
    if (a.standstills != b.standstills) return a.standstills > b.standstills;
    return std::abs(a.clock.rate) < std::abs(b.clock.rate);
  };
  std::ranges::stable_sort(matches, most_first);
  std::vector<StandstillMatch> different;
  std::set<std::vector<int>> known;
  for (StandstillMatch match : matches) {
    if (2 * match.standstills < matches.front().standstills || different.size() == kMaxMatches)
      break;
    if (!known.insert(match.standstill).second) continue;
    for (int round = 0; round < 3; ++round) {
      const ClockFit clock = refined(standstills, readings, match, tolerance);
      const StandstillMatch better = match_by_clock(standstills, readings, clock, tolerance);
      if (better.standstills < match.standstills) break;
      match = better;
    }
    // Two ways that pair most readings in the same way are one, with slightly different clocks.
    const auto alike = [&](const StandstillMatch& other) {
      int same = 0, paired = 0;
      for (size_t r = 0; r < readings.size(); ++r) {
        paired += match.standstill[r] >= 0;
        same += match.standstill[r] >= 0 && match.standstill[r] == other.standstill[r];
      }
      return 2 * same > paired;
    };
    const auto other = std::ranges::find_if(different, alike);
    if (other == different.end())
      different.push_back(match);
    else if (match.standstills > other->standstills)
      *other = match;
  }
  std::ranges::stable_sort(different, most_first);
  return different;
}

}  // namespace armtrue
