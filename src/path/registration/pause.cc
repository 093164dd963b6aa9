#include "armtrue/path/registration/pause.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "armtrue/statistics/summary.h"
#include "path/registration/formatted.h"

namespace armtrue {
namespace {

constexpr double kStep = 0.1;           // [s]
constexpr double kShortestPause = 0.3;  // [s]: at a corner an arm may stand for a shorter time
constexpr double kStill = 0.1;          // of the usual way in a step
constexpr double kLeastWay = 5e-3;      // [m] from both ends, and along the program in the pause
constexpr double kJump = 3;             // usual ways in a step: the instrument stood, not the tool
constexpr double kSamePlace = 0.03;     // of the way: noise makes that of a record longer

struct Stop {
  double begin, duration;  // [s]
  double share;            // of the way
};

// The way in each step, and its sum up to the step.
struct Steps {
  std::vector<double> ways, sums;
  double begin;

  explicit Steps(const Path& path) : begin(path.time[0]) {
    const Eigen::Index last = path.samples() - 1;
    const auto count = static_cast<Eigen::Index>((path.time[last] - begin) / kStep);
    const Eigen::Matrix3Xd places = position_at(
        path,
        Eigen::VectorXd::LinSpaced(count + 1, begin, begin + kStep * static_cast<double>(count)));
    double sum = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      ways.push_back((places.col(k + 1) - places.col(k)).norm());
      sums.push_back(sum);
      sum += ways.back();
    }
    sums.push_back(sum);
  }

  double usual() const {
    std::vector<double> moved;
    for (double way : ways)
      if (way > kStandstill) moved.push_back(way);
    return moved.empty() ? 0 : median(moved);
  }

  std::vector<Stop> stops(double usual) const {
    const double still = kStill * usual;
    std::vector<Stop> found;
    const double all = sums.back();
    for (size_t k = 0; k < ways.size(); ++k) {
      if (ways[k] >= still) continue;
      size_t end = k;
      while (end < ways.size() && ways[end] < still) ++end;
      const bool jumps = end < ways.size() && ways[end] > kJump * usual;
      // The tool stops and starts within the steps beside those in which it stands.
      const double before = k > 0 ? std::max(0.0, 1 - ways[k - 1] / usual) : 0,
                   after = end < ways.size() ? std::max(0.0, 1 - ways[end] / usual) : 0;
      if (!jumps && sums[k] > kLeastWay && all - sums[end] > kLeastWay)
        found.push_back({begin + kStep * (static_cast<double>(k) - before),
                         kStep * (static_cast<double>(end - k) + before + after), sums[k] / all});
      k = end;
    }
    return found;
  }
};

}  // namespace

std::optional<Pause> find_pause(const Path& programmed, const Path& measured) {
  const Steps wanted(programmed), seen(measured);
  const double usual = wanted.usual();
  const std::vector<Stop> programmed_stops = wanted.stops(usual);
  std::optional<Pause> found;
  for (const Stop& stop : seen.stops(usual)) {
    double longer = stop.duration;
    for (const Stop& own : programmed_stops)
      if (std::abs(own.share - stop.share) < kSamePlace) longer -= own.duration;
    if (longer <= std::max(kShortestPause, found ? found->longer : 0) ||
        longer * usual / kStep <= kLeastWay)
      continue;
    const double* time = measured.time.data();
    const Eigen::Index sample =
        std::lower_bound(time, time + measured.samples(), stop.begin) - time;
    found = Pause{sample, stop.begin, longer, usual / kStep};
  }
  return found;
}

std::string in_words(const Pause& pause) {
  return "stands at " + formatted("%.4g", pause.begin) + " s, for " +
         formatted("%.2g", pause.longer) +
         " s longer than the program does near that place: did the pass pause, as by a feed hold? "
         "What comes after it has other times than the program: record the pass without a pause, "
         "or give the program with the times at which it ran";
}

}  // namespace armtrue
