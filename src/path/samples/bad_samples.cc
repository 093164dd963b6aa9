#include "armtrue/path/samples/bad_samples.h"

#include <algorithm>
#include <string>
#include <utility>

#include "path/samples/departures.h"
#include "path/samples/frozen_readings.h"
#include "path/samples/plausible_motion.h"

namespace armtrue {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

bool earlier(const BadSample& a, const BadSample& b) { return a.sample < b.sample; }

struct Piece {
  Index first, last;
};

// Removes lost locks: pieces of the record that begin and end with a jump that no tool can make.
class JumpFilter {
 public:
  JumpFilter(const Path& path, double speed, const std::vector<Index>& samples)
      : path_(path), speed_(speed), samples_(samples) {
    for (Index k = 0; k < std::ssize(samples); ++k) {
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
  Index sample(Index k) const { return samples_[k]; }
  Index length(size_t k) const { return pieces_[k].last - pieces_[k].first + 1; }
  // Instruments write zeros while they have lost the target.
  bool is_zero(size_t k) const { return path_.position.col(sample(pieces_[k].first)).isZero(0); }
  double jump(Index a, Index b) const {
    return (path_.position.col(sample(b)) - path_.position.col(sample(a))).norm();
  }
  bool reaches(Index a, Index b) const {
    const double duration = std::abs(path_.time[sample(b)] - path_.time[sample(a)]);
    return jump(a, b) <= kMaxDeviation + speed_ * duration;
  }

  // The end of a piece without a run of bad samples there, to which the step was just possible.
  Index sound_end(size_t k, int direction) const {
    const auto [first, last] = pieces_[k];
    const Index end = direction > 0 ? last : first, other = direction > 0 ? first : last;
    for (Index i = end; i != other && std::abs(end - i) < kMaxRun; i -= direction)
      if (jump(i - direction, i) > 0.5 * kMaxDeviation) return i - direction;
    return end;
  }

  // Whether the tool can go on from a good piece to another one.
  bool goes_on(size_t good, size_t piece, int direction) const {
    const auto end = [&](size_t k, int side) {
      return side > 0 ? pieces_[k].last : pieces_[k].first;
    };
    return reaches(end(good, direction), end(piece, -direction)) ||
           reaches(sound_end(good, direction), sound_end(piece, -direction));
  }

  // Goes from a good piece to those that the tool can have reached from there. After the last of
  // them the record never returns: such a step may be real, and longer pieces are kept.
  void follow(std::ptrdiff_t from, int direction) {
    const std::ptrdiff_t end = direction > 0 ? std::ssize(pieces_) : -1;
    std::ptrdiff_t good = from;
    for (std::ptrdiff_t piece = from + direction; piece != end; piece += direction) {
      if (is_zero(piece) || !goes_on(good, piece, direction)) continue;
      kept_[piece] = true;
      good = piece;
    }
    for (std::ptrdiff_t piece = good + direction; piece != end; piece += direction) {
      kept_[piece] = length(piece) > kMaxRun && !is_zero(piece);
    }
  }

  const Path& path_;
  double speed_;
  const std::vector<Index>& samples_;
  std::vector<Piece> pieces_;  // of samples_, by index
  std::vector<bool> kept_;
};

// The samples that are not good, with their distance from the straight line between the good ones
// on both sides, or from the only good one. Samples within the tolerance are left out: a good
// sample between two bad ones looks bad until they are gone, and a repeated reading until its
// deviation is known.
std::vector<BadSample> bad_among(const Path& path, const WithoutDepartures& left) {
  const std::vector<Index>& good = left.good;
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
    const double off = (path.position.col(i) - expected).norm();
    if (off > left.tolerance) bad.push_back({i, off});
  }
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
  const auto has_left = [&](Index k, Index next, double jump) { return jump > travel(k, next); };
  const std::vector<Index> live = not_frozen(measured.position, travel, has_left);
  return bad_among(measured,
                   without_departures(programmed, measured, speed, rounding(measured.position),
                                      JumpFilter(measured, speed, live).good_samples()));
}

std::vector<BadSample> find_bad_deviations(const Path& deviation, const Eigen::Matrix3Xd& wanted,
                                           const std::vector<BadSample>& known) {
  if (deviation.samples() < 2) return {};
  // Travel along the program, one sample more on either side: the clock may be off by as much.
  const auto travel = [&](Index from, Index to) {
    double length = 0;
    for (Index i = std::max<Index>(from, 1); i <= std::min<Index>(to + 1, deviation.samples() - 1);
         ++i)
      length += (wanted.col(i) - wanted.col(i - 1)).norm();
    return length;
  };
  const auto has_left = [](Index, Index, double) { return true; };  // see bad_among()
  Eigen::Matrix3Xd readings = deviation.position + wanted;
  const double rounded = rounding(readings);
  std::vector<Index> live = not_frozen(readings, travel, has_left);
  readings.resize(3, 0);  // frees memory
  std::erase_if(live, [&](Index i) {
    return std::binary_search(known.begin(), known.end(), BadSample{i, 0}, earlier);
  });
  return bad_among(deviation, without_departures(deviation, wanted, rounded, std::move(live)));
}

bool too_many(const std::vector<BadSample>& bad, const Path& measured) {
  return static_cast<double>(bad.size()) > kMaxBadShare * measured.samples();
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
  std::vector<bool> good(path.samples(), true);
  for (const BadSample& b : bad) good[b.sample] = false;
  std::vector<Index> kept;
  for (Index i = 0; i < path.samples(); ++i)
    if (good[i]) kept.push_back(i);
  Path rest;
  rest.time = path.time(kept);
  rest.position = path.position(Eigen::all, kept);
  if (path.has_orientation()) rest.orientation = path.orientation(Eigen::all, kept);
  if (path.has_joints()) rest.q = path.q(Eigen::all, kept);
  if (path.has_force()) rest.force = path.force(Eigen::all, kept);
  return rest;
}

}  // namespace armtrue
