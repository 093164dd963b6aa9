#include "path/registration/feed.h"

#include <Eigen/Geometry>
#include <cmath>

#include "linear_algebra/decompositions.h"
#include "path/registration/first_offset.h"
#include "path/registration/formatted.h"

namespace armtrue {
namespace {

constexpr double kLeastAway = 5e-3;   // [m] from the first and the last place
constexpr double kClockError = 0.01;  // of the time in motion: ten times that of any clock

struct Motion {
  double begin = 0, end = 0;
  double time() const { return end - begin; }
};

std::optional<Motion> motion_of(const Path& path) {
  const Eigen::Index last = path.samples() - 1;
  Eigen::Index begin = 0, end = last;
  const auto is_away = [&](Eigen::Index i, Eigen::Index from) {
    return (path.position.col(i) - path.position.col(from)).norm() > kLeastAway;
  };
  while (begin < last && !is_away(begin, 0)) ++begin;
  while (end > 0 && !is_away(end, last)) --end;
  if (end <= begin) return std::nullopt;
  return Motion{path.time[begin], path.time[end]};
}

}  // namespace

std::optional<OtherFeed> find_other_feed(const Path& programmed, const Path& measured) {
  const auto wanted = motion_of(programmed), seen = motion_of(measured);
  if (!wanted || !seen) return std::nullopt;
  const double ratio = seen->time() / wanted->time();
  const Eigen::VectorXd length = arc_length(programmed);
  const double speed = length[length.size() - 1] / wanted->time();
  if (std::abs(ratio - 1) <= kClockError ||
      std::abs(ratio - 1) * wanted->time() * speed <= kLeastAway)
    return std::nullopt;
  OtherFeed feed{ratio, seen->time(), {}};
  feed.stretch.rate = ratio - 1;
  feed.stretch.offset = seen->begin - ratio * wanted->begin;
  return feed;
}

bool joins(const Path& programmed, const Path& measured, const OtherFeed& feed, bool fit_frame) {
  const ClockFit& stretch = feed.stretch;
  Path record = measured;
  if (fit_frame) {
    const Eigen::Matrix4d motion = Eigen::umeyama(
        record.position,
        position_at(programmed, (record.time.array() - stretch.offset) / (1 + stretch.rate)),
        false);
    record.position = (motion.topLeftCorner<3, 3>() * measured.position).colwise() +
                      Eigen::Vector3d(motion.topRightCorner<3, 1>());
  }
  return mean_square_distance(programmed, record, stretch.offset, stretch.rate) <
         kMaxPathDistance * kMaxPathDistance;
}

std::string in_words(const OtherFeed& feed) {
  return "moves for " + formatted("%.4g", feed.moving) + " s, " + formatted("%.4g", feed.ratio) +
         " times as long as the program: it ran at another feed, as an override of " +
         formatted("%.3g", 100 / feed.ratio) +
         " % does. Servos and forces deviate otherwise at another feed: record the pass at the "
         "programmed one, or give the program with the times at which it ran";
}

}  // namespace armtrue
