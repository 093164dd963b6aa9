#include "path/mirror/breaks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/units.h"
#include "armtrue/statistics/summary.h"
#include "path/mirror/corners.h"

namespace armtrue {
namespace {

constexpr double kReversal = 0.01 * kDegree;  // of travel back, to count as one
constexpr Eigen::Index kShortest = 4;         // samples of a piece
constexpr double kFinest = 1e-7;              // [m]: nothing is read to less

// Places where a joint turns back.
void add_reversals(const Path& path, std::vector<double>& times) {
  for (int joint = 0; joint < kJoints; ++joint) {
    double extreme = path.q(joint, 0);
    Eigen::Index at = 0;
    int direction = 0;
    for (Eigen::Index i = 1; i < path.samples(); ++i) {
      const double moved = path.q(joint, i) - extreme;
      if (direction * moved >= 0 && (direction != 0 || std::abs(moved) < kReversal)) {
        if (moved != 0) at = i;
        extreme = path.q(joint, i);
      } else if (std::abs(moved) > kReversal) {
        if (direction != 0) times.push_back(path.time[at]);
        direction = moved > 0 ? 1 : -1;
        extreme = path.q(joint, i);
        at = i;
      }
    }
  }
}

class JumpSearch {
 public:
  JumpSearch(const Eigen::Matrix3Xd& samples, double noise, Eigen::Index window,
             const std::vector<Eigen::Index>& likely)
      : noise_(std::max(noise, kFinest)), window_(window), likely_(samples.cols(), false) {
    for (const Eigen::Index i : likely)
      if (i >= 0 && i < samples.cols()) likely_[static_cast<size_t>(i)] = true;
    sums_.resize(3, samples.cols() + 1);
    sums_.col(0).setZero();
    for (Eigen::Index i = 0; i < samples.cols(); ++i)
      sums_.col(i + 1) = sums_.col(i) + samples.col(i);
    // A jump across the path has two components: P(chi^2_2 > x) = exp(-x / 2). Where the deviation
    // moves all the time, slopes make every statistic larger: a jump has to stand out of its
    // median.
    constexpr double kChance = 1e-3;  // of any jump in a record that has none
    const double usual = std::max(1.0, median_statistic() / (2 * std::numbers::ln2));
    anywhere_ = -2 * std::log(kChance / static_cast<double>(samples.cols())) * usual;
    at_likely_ = -2 * std::log(0.01) * usual;
  }

  void split(Eigen::Index begin, Eigen::Index end, std::vector<Eigen::Index>& jumps) const {
    // A long path has many pieces: a stack of its own, instead of one call in the other.
    std::vector<std::pair<Eigen::Index, Eigen::Index>> open{{begin, end}};
    while (!open.empty()) {
      const auto [first, last] = open.back();
      open.pop_back();
      Eigen::Index best = -1;
      double highest = 1;
      for (Eigen::Index i = first + kShortest; i + kShortest <= last; ++i) {
        const double here =
            statistic(first, i, last) / (likely_[static_cast<size_t>(i)] ? at_likely_ : anywhere_);
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
    for (Eigen::Index i = kShortest; i + kShortest <= end; ++i) all.push_back(statistic(0, i, end));
    return all.empty() ? 0 : median(std::move(all));
  }

  double noise_;
  Eigen::Index window_;
  std::vector<bool> likely_;
  Eigen::Matrix3Xd sums_;
  double anywhere_, at_likely_;
};

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
  if (programmed.has_joints()) add_reversals(programmed, times);
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

}  // namespace armtrue
