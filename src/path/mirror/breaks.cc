#include "path/mirror/breaks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/path/joint_reversals.h"
#include "armtrue/path/mirror/engagement.h"
#include "armtrue/statistics/summary.h"
#include "path/mirror/corners.h"

namespace armtrue {
namespace {

constexpr Eigen::Index kMinPiece = 4;            // samples
constexpr double kMinNoise = 1e-7;               // [m]: no instrument reads more finely
constexpr double kJumpWindow = 0.32;  // [s], ten samples of 32 ms: noise falls to a third

// Splits samples at the largest jump of the mean, as long as it is significant. With m the means of
// up to `window` samples before and after sample i, n their numbers, the statistic of a jump at i
// is
//     |m_after - m_before|^2 / (noise^2 (1 / n_before + 1 / n_after)).
class JumpSearch {
 public:
  JumpSearch(const Eigen::Matrix3Xd& samples, double noise, Eigen::Index window,
             const std::vector<Eigen::Index>& likely)
      : noise_(std::max(noise, kMinNoise)), window_(window), likely_(samples.cols(), false) {
    for (const Eigen::Index i : likely)
      if (i >= 0 && i < samples.cols()) likely_[i] = true;
    sums_.resize(3, samples.cols() + 1);
    sums_.col(0).setZero();
    for (Eigen::Index i = 0; i < samples.cols(); ++i)
      sums_.col(i + 1) = sums_.col(i) + samples.col(i);
    // A jump across the path has two components: P(chi^2_2 > x) = exp(-x / 2). Slopes of the
    // deviation make every statistic larger, so it is divided by its median over that of chi^2_2.
    constexpr double kChance = 1e-3;  // of any jump in a record that has none
    const double usual = std::max(1.0, median_statistic() / (2 * std::numbers::ln2));
    anywhere_ = -2 * std::log(kChance / static_cast<double>(samples.cols())) * usual;
    at_likely_ = -2 * std::log(0.01) * usual;
  }

  void split(Eigen::Index begin, Eigen::Index end, std::vector<Eigen::Index>& jumps) const {
    // A stack instead of recursion: a long path has many pieces.
    std::vector<std::pair<Eigen::Index, Eigen::Index>> open{{begin, end}};
    while (!open.empty()) {
      const auto [first, last] = open.back();
      open.pop_back();
      Eigen::Index best = -1;
      double highest = 1;
      for (Eigen::Index i = first + kMinPiece; i + kMinPiece <= last; ++i) {
        const double here = statistic(first, i, last) / (likely_[i] ? at_likely_ : anywhere_);
        if (here <= highest) continue;
        highest = here;
        best = i;
      }
      if (best < 0) continue;
      jumps.push_back(best);
      open.emplace_back(first, best);
      open.emplace_back(best, last);
    }
  }

 private:
  double statistic(Eigen::Index first, Eigen::Index i, Eigen::Index last) const {
    const Eigen::Index before = std::min(window_, i - first), after = std::min(window_, last - i);
    const auto left = static_cast<double>(before), right = static_cast<double>(after);
    const Eigen::Vector3d jump = (sums_.col(i + after) - sums_.col(i)) / right -
                                 (sums_.col(i) - sums_.col(i - before)) / left;
    return jump.squaredNorm() / (noise_ * noise_ * (1 / left + 1 / right));
  }

  double median_statistic() const {
    const Eigen::Index end = sums_.cols() - 1;
    std::vector<double> all;
    for (Eigen::Index i = kMinPiece; i + kMinPiece <= end; ++i) all.push_back(statistic(0, i, end));
    return all.empty() ? 0 : median(std::move(all));
  }

  double noise_;
  Eigen::Index window_;
  std::vector<bool> likely_;
  Eigen::Matrix3Xd sums_;
  double anywhere_, at_likely_;
};

// Removes engagements that begin or end at a break of the program: without a force the deviation
// shows the cut, but a corner or a reversal makes a step too.
void drop_other_causes(const std::vector<double>& breaks, PathDeviation& deviation) {
  const auto at_break = [&](const std::optional<Instant>& instant) {
    return instant && std::any_of(breaks.begin(), breaks.end(), [&](double time) {
             return std::abs(time - instant->time) <= instant->uncertainty + deviation.period;
           });
  };
  std::erase_if(deviation.engagement.intervals,
                [&](const Engagement& e) { return at_break(e.entry) || at_break(e.exit); });
}

}  // namespace

std::vector<double> program_breaks(const Path& programmed) {
  std::vector<double> times;
  for (const Corner& corner : find_corners(programmed))
    for (const Eigen::Index i : {corner.last, corner.last + 1}) times.push_back(programmed.time[i]);
  for (Eigen::Index i = 1; i < programmed.samples(); ++i) {
    const auto moves = [&](Eigen::Index k) {
      return k + 1 < programmed.samples() &&
             programmed.position.col(k + 1) != programmed.position.col(k);
    };
    if (moves(i) != moves(i - 1)) times.push_back(programmed.time[i]);
  }
  for (const JointReversal& reversal : joint_reversals(programmed.time, programmed.q))
    times.push_back(reversal.time);
  std::sort(times.begin(), times.end());
  return times;
}

std::vector<Eigen::Index> find_jumps(const Eigen::Matrix3Xd& samples, double noise,
                                     Eigen::Index window, const std::vector<Eigen::Index>& likely) {
  std::vector<Eigen::Index> jumps;
  JumpSearch(samples, noise, window, likely).split(0, samples.cols(), jumps);
  std::sort(jumps.begin(), jumps.end());
  return jumps;
}

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

}  // namespace armtrue
